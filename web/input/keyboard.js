// The keyboard as two sticks (WASD and the arrows by default), by KeyboardEvent.code: the same places on every layout.

import { codeOf } from "./keyboard_layout.js";
import { KEY_ACTIONS } from "./mapping.js";

/** @typedef {import("./mapping.js").KeySet} KeySet */
/** @typedef {import("./stick.js").Stick} Stick */
/** @typedef {{stick: Stick, backward: boolean, grabs: number, pings: number}} Reading  presses since the last one */

const TYPING = "input, textarea, select, [contenteditable]";
const SHIFTS = ["ShiftLeft", "ShiftRight"];
const CLICKING = "button, a[href], summary, [role=button]";

export class Keyboard {
  /** @type {Set<string>} */
  #down = new Set();
  /** @type {string[]} presses since the last reading, by code */
  #pressed = [];
  /** @type {() => readonly KeySet[]} */
  #keySets;
  /** @type {() => void} */
  #onChange;
  /** @type {(code: string) => boolean} */
  #claims;

  /**
   * @param {EventTarget} target  usually window
   * @param {() => readonly KeySet[]} keySets  asked at each event, so that a remapping holds at once
   * @param {() => void} onChange  called inside the event: the quickest way to the wire
   * @param {(code: string) => boolean} [claims]  keys that are read even where a focused button would take them
   */
  constructor(target, keySets, onChange, claims = () => false) {
    this.#keySets = keySets;
    this.#onChange = onChange;
    this.#claims = claims;
    target.addEventListener("keydown", (event) => this.#keydown(/** @type {KeyboardEvent} */ (event)));
    target.addEventListener("keyup", (event) => this.#keyup(/** @type {KeyboardEvent} */ (event)));
  }

  /** Releases all keys: the page has lost the focus and will not see keyup events. */
  release() {
    this.#down.clear();
    this.#pressed = [];
  }

  /** @param {KeyboardEvent} event */
  #keydown(event) {
    this.#forgetShifts(event);
    const code = codeOf(event);
    const bound = this.#keySets().some((keys) => KEY_ACTIONS.some((action) => keys[action] === code));
    if (!bound || event.ctrlKey || event.metaKey || event.altKey || this.#belongsToPage(event)) return;
    event.preventDefault(); // arrows and space would scroll
    if (event.repeat || this.#down.has(code)) return;
    this.#down.add(code);
    this.#pressed.push(code);
    this.#onChange();
  }

  /** @param {KeyboardEvent} event */
  #keyup(event) {
    this.#forgetShifts(event);
    const isCommand = event.key === "Meta" || event.key === "OS"; // while it is down, macOS tells of no key let go
    if (isCommand) this.release();
    if (this.#down.delete(codeOf(event)) || isCommand) this.#onChange();
  }

  /** Of two Shift keys that are down, Windows tells only that the last one was let go. @param {KeyboardEvent} event */
  #forgetShifts(event) {
    const gone = event.shiftKey === false ? SHIFTS.filter((code) => this.#down.delete(code)) : [];
    if (gone.length > 0) this.#onChange();
  }

  /** Whether any key of the set is down. @param {KeySet} keys */
  isUsed(keys) {
    return KEY_ACTIONS.some((action) => this.#down.has(keys[action]) || this.#pressed.includes(keys[action]));
  }

  /** @param {KeySet} keys @returns {Reading} */
  read(keys) {
    const down = (/** @type {string} */ code) => Number(this.#down.has(code));
    const x = down(keys.right) - down(keys.left);
    const y = down(keys.up) - down(keys.down);
    const length = Math.max(1, Math.hypot(x, y));
    const presses = (/** @type {string} */ key) => this.#pressed.filter((code) => code === key).length;
    const [grabs, pings] = [presses(keys.grab), presses(keys.ping)];
    this.#pressed = this.#pressed.filter((code) => !KEY_ACTIONS.some((action) => keys[action] === code));
    return { stick: { x: x / length, y: y / length }, backward: this.#down.has(keys.backward), grabs, pings };
  }

  /** Whether a key is meant for a dialog, a field or a focused button. @param {KeyboardEvent} event */
  #belongsToPage(event) {
    const target = event.target;
    if (typeof Element === "undefined" || !(target instanceof Element)) return false;
    if (document.querySelector("dialog[open]") !== null) return true; // also where nothing in it has the focus
    if (target.closest(TYPING) !== null) return true;
    const code = codeOf(event);
    if (code !== "Space" && code !== "Enter") return false;
    return target.closest(CLICKING) !== null && !this.#claims(code);
  }
}
