// @ts-check
/*
 * Which controls one person has tried: each direction once, and grab. Pure.
 */

/** @typedef {import("../../input/seats.js").SeatReading} SeatReading */
/** @typedef {"up" | "left" | "down" | "right" | "grab"} Control */

export const CONTROLS = /** @type {const} */ (["up", "left", "down", "right", "grab"]);
const FAR = 0.4; // of the way that a stick goes

export class TriedControls {
  /** @type {Set<Control>} */
  done = new Set();

  /** @param {boolean} gamepadOnly presses on other devices do not count */
  constructor(gamepadOnly) {
    this.gamepadOnly = gamepadOnly;
  }

  /** @returns {Control[]} what is still to be tried */
  get todo() {
    return CONTROLS.filter((control) => !this.done.has(control));
  }

  /** @param {SeatReading} reading @returns {boolean} whether it showed something new */
  add({ stick, grabs, device }) {
    if (this.gamepadOnly && device !== "gamepad") return false;
    const before = this.done.size;
    if (stick.y > FAR) this.done.add("up");
    if (stick.y < -FAR) this.done.add("down");
    if (stick.x < -FAR) this.done.add("left");
    if (stick.x > FAR) this.done.add("right");
    if (grabs > 0) this.done.add("grab");
    return this.done.size > before;
  }
}
