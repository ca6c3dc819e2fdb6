// A person at the keyboard, for tests: looks at the page's own state once per tick and presses real keys (through
// `pressKey`, which Playwright provides), because a test that looks from outside is too slow on a busy machine.
// It heads for places and items in the eight directions that keys give, as people do, and corrects on the way.

const ROBOT_RADIUS = 0.12;
const ITEM_RADIUS = 0.06; // of the small items
const NEAR = 0.1;
const DIRECTIONS = [
  ["up"],
  ["up", "left"],
  ["left"],
  ["down", "left"],
  ["down"],
  ["down", "right"],
  ["right"],
  ["up", "right"],
];
const EIGHTH = Math.PI / 4;
const KEY_SETS = {
  wasd: { up: "KeyW", left: "KeyA", down: "KeyS", right: "KeyD", grab: "Space", backward: "ShiftLeft" },
  arrows: {
    up: "ArrowUp",
    left: "ArrowLeft",
    down: "ArrowDown",
    right: "ArrowRight",
    grab: "Enter",
    backward: "ShiftRight",
  },
};

class Over extends Error {}
class Stuck extends Error {}

class Pilot {
  constructor(seat, keys) {
    this.seat = seat;
    this.keys = KEY_SETS[keys];
    this.down = new Set();
    this.course = -1; // index into DIRECTIONS
    this.patience = Infinity; // the tick at which it gives up what it is trying
  }

  get game() {
    return window.__movingout;
  }

  get robot() {
    return this.game.entities().robots[this.seat];
  }

  item(index) {
    return this.game.entities().items[index];
  }

  /** Hold exactly these keys until the next tick is shown. */
  async hold(...wanted) {
    const keys = new Set(wanted.map((name) => this.keys[name]));
    for (const key of this.down) if (!keys.has(key)) void window.pressKey(key, "up");
    for (const key of keys) if (!this.down.has(key)) void window.pressKey(key, "down");
    this.down = keys;
    const tick = this.game.tick;
    if (tick > this.patience) throw new Stuck();
    while (this.game.tick === tick) {
      if (this.game.phase.endsWith("_over")) throw new Over();
      await new Promise((resolve) => requestAnimationFrame(resolve));
    }
  }

  /** The keys for the direction nearest to a place; keeps the course until it is well off. */
  towards(x, y) {
    const bearing = bearingOf(this.robot, x, y);
    if (this.course === -1 || Math.abs(wrap(bearing - this.course * EIGHTH)) > 0.75 * EIGHTH) {
      this.course = (Math.round(bearing / EIGHTH) + 8) % 8;
    }
    return DIRECTIONS[this.course];
  }

  /** Drive to a place. */
  async go(x, y, near = NEAR) {
    while (Math.hypot(x - this.robot.x, y - this.robot.y) > near) await this.hold(...this.towards(x, y));
  }

  /** Drive to a place without turning round: what is carried stays on its side. */
  async back(x, y, near = NEAR) {
    while (Math.hypot(x - this.robot.x, y - this.robot.y) > near) await this.hold("backward", ...this.towards(x, y));
  }

  /** Keep one direction until a coordinate has passed a value. */
  async drive(direction, axis, value) {
    const sign = direction === "up" || direction === "right" ? 1 : -1;
    while (sign * (value - this.robot[axis]) > 0) await this.hold(direction);
  }

  /** Drive at an item until it is in reach and ahead, and take it. */
  async grab(index) {
    while (this.robot.held !== index) {
      const item = this.item(index);
      const { x, y, angle } = this.robot;
      const gap = Math.hypot(item.x - x, item.y - y) - ROBOT_RADIUS - ITEM_RADIUS;
      const off = Math.abs(wrap(bearingOf(this.robot, item.x, item.y) - angle));
      if (gap < 0.05) this.course = -1; // close to it, it faces as straight as eight directions allow
      if (gap < 0.02 && off < 0.4) await this.press("grab", () => this.robot.held === index);
      else await this.hold(...this.towards(item.x, item.y));
    }
  }

  /** Let go of what is in the hand. */
  async drop() {
    await this.press("grab", () => this.robot.held === -1);
  }

  /** Drive towards a place until the item in hand counts as delivered, and let go of it. */
  async deliver(index, x, y) {
    while (!this.item(index).delivered) await this.hold(...this.towards(x, y));
    await this.drop();
  }

  /** Follow steps until an item counts as delivered; from the start again when an attempt takes too long, or fails. */
  async until(index, ticks, steps) {
    while (!this.item(index).delivered) {
      this.patience = this.game.tick + ticks;
      try {
        await this.follow(steps);
      } catch (error) {
        if (!(error instanceof Stuck)) throw error;
      }
      this.patience = Infinity;
      if (this.robot.held !== -1) await this.drop();
    }
  }

  async follow(steps) {
    for (const [what, ...how] of steps) await this[what](...how);
  }

  /** Keep one direction until it goes no farther. */
  async shove(direction) {
    for (let still = 0, last = this.robot; still < 5; last = this.robot) {
      await this.hold(direction);
      still = Math.hypot(this.robot.x - last.x, this.robot.y - last.y) < 0.005 ? still + 1 : 0;
    }
  }

  /** One press, then patience for half a second. */
  async press(name, done) {
    await this.hold();
    await window.pressKey(this.keys[name], "press");
    for (let ticks = 0; ticks < 5 && !done(); ticks += 1) await this.hold();
  }
}

/** Where a place lies as seen from a robot: 0 is up, counter-clockwise. */
function bearingOf(robot, x, y) {
  return Math.atan2(robot.x - x, y - robot.y);
}

function wrap(angle) {
  return Math.atan2(Math.sin(angle), Math.cos(angle));
}

/** Follows `plan` until it or the round is over. */
window.__pilot = async (seat, keys, plan) => {
  const pilot = new Pilot(seat, keys);
  try {
    await pilot.follow(plan);
    return "done";
  } catch (error) {
    if (error instanceof Over) return "over";
    throw error;
  } finally {
    for (const key of pilot.down) void window.pressKey(key, "up");
  }
};
