// @ts-check
/*
 * The controls that one person has tried: each direction, grab and driving backward. Pure.
 */

/** @typedef {import("../../input/seats.js").SeatReading} SeatReading */
/** @typedef {"up" | "left" | "down" | "right" | "grab" | "backward"} Control */

export const CONTROLS = /** @type {const} */ (["up", "left", "down", "right", "grab", "backward"]);
const FAR = 0.4; // share of a stick's full deflection

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

  /** Whether a press of a key would be the first that counts for this control. @param {Control} control */
  awaits(control) {
    return !this.gamepadOnly && !this.done.has(control);
  }

  /** @param {SeatReading} reading @returns {boolean} whether it showed something new */
  add({ stick, grabs, backward, device }) {
    if (this.gamepadOnly && device !== "gamepad") return false;
    const before = this.done.size;
    if (stick.y > FAR) this.done.add("up");
    if (stick.y < -FAR) this.done.add("down");
    if (stick.x < -FAR) this.done.add("left");
    if (stick.x > FAR) this.done.add("right");
    if (grabs > 0) this.done.add("grab");
    if (backward) this.done.add("backward");
    return this.done.size > before;
  }
}
