// Gamepads, polled each frame because browsers hand out snapshots. Unplugging needs no event: a pad that is gone is not
// in the list. Presses are found by comparing with the previous poll.

import { CENTRED, strongest, withDeadZone } from "./stick.js";

/** @typedef {import("./keyboard.js").Reading} Reading */
/** @typedef {import("./mapping.js").Mapping} Mapping */
/** @typedef {Reading & {id: string, index: number, active: boolean, pauses: number}} PadReading */

const PRESSED = 0.5; // a trigger counts as pressed from half way
const D_PAD = { up: 12, down: 13, left: 14, right: 15 };
// Pads that the browser does not know have their d-pad elsewhere.
const HAT = { axes: 10, axis: 9, steps: 7 }; // Windows and macOS: eight directions from -1 (up) clockwise to 1
const HAT_PAIR = { axes: 8, x: 6, y: 7 }; // Linux

export class Gamepads {
  /** @type {() => readonly (Gamepad | null)[]} */
  #poll;
  /** @type {Map<number, readonly boolean[]>} pressed buttons of the last poll, by index of the pad */
  #before = new Map();

  /** @param {() => readonly (Gamepad | null)[]} poll  usually navigator.getGamepads */
  constructor(poll) {
    this.#poll = poll;
  }

  /** All pads that are plugged in and were touched once. @param {Mapping} mapping @returns {PadReading[]} */
  read(mapping) {
    const pads = this.#poll().filter((pad) => pad !== null && pad.connected);
    const readings = pads.map((pad) => this.#readOne(/** @type {Gamepad} */ (pad), mapping));
    const present = new Set(readings.map((reading) => reading.index));
    for (const index of this.#before.keys()) if (!present.has(index)) this.#before.delete(index);
    return readings;
  }

  /**
   * The first button that is newly pressed on any pad, for remapping; null when there is none.
   * @param {Mapping} mapping
   */
  pressedButton(mapping) {
    const before = new Map(this.#before);
    this.read(mapping);
    for (const [index, buttons] of this.#before) {
      const pressed = buttons.findIndex((down, button) => down && !before.get(index)?.[button]);
      if (pressed !== -1) return pressed;
    }
    return null;
  }

  /** @param {Gamepad} pad @param {Mapping} mapping @returns {PadReading} */
  #readOne(pad, mapping) {
    const down = pad.buttons.map((button) => button.pressed || button.value >= PRESSED);
    // A pad seen for the first time was woken by a press that is still down: that press counts.
    const before = this.#before.get(pad.index) ?? [];
    this.#before.set(pad.index, down);
    const edge = (/** @type {number} */ button) => Number(down[button] === true && before[button] !== true);
    const leftStick = withDeadZone(pad.axes[0] ?? 0, -(pad.axes[1] ?? 0), mapping.deadZone);
    const stick = strongest([leftStick, dPad(down), hat(pad)]);
    const [grabs, pings, pauses] = [mapping.buttons.grab, mapping.buttons.ping, mapping.buttons.pause].map(edge);
    const active = grabs > 0 || stick.x !== 0 || stick.y !== 0 || down.some(Boolean);
    const backward = down[mapping.buttons.backward] === true;
    return { id: pad.id, index: pad.index, stick, backward, grabs, pings, pauses, active };
  }
}

/** @param {readonly boolean[]} down */
function dPad(down) {
  const x = Number(down[D_PAD.right] ?? false) - Number(down[D_PAD.left] ?? false);
  const y = Number(down[D_PAD.up] ?? false) - Number(down[D_PAD.down] ?? false);
  const length = Math.max(1, Math.hypot(x, y));
  return { x: x / length, y: y / length };
}

/** The d-pad of a pad without the standard mapping. @param {Gamepad} pad */
function hat({ mapping, axes }) {
  if (mapping === "standard") return CENTRED;
  if (axes.length === HAT_PAIR.axes) return withDeadZone(axes[HAT_PAIR.x], -axes[HAT_PAIR.y], PRESSED);
  const step = ((axes[HAT.axis] + 1) / 2) * HAT.steps;
  const rests = axes.length !== HAT.axes || step > HAT.steps + 0.2 || Math.abs(step - Math.round(step)) > 0.2;
  const angle = (Math.round(step) * Math.PI) / 4;
  return rests ? CENTRED : { x: Math.sin(angle), y: Math.cos(angle) };
}
