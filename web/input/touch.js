// Touch: a stick that appears where a thumb comes down in the left zone, and a grab and a backward button.
// Pointer events, so a pen or a mouse works too; each finger is followed by its pointer id.

import { onPress } from "./press.js";
import { CENTRED, lengthOf } from "./stick.js";

/** @typedef {import("./keyboard.js").Reading} Reading */
/** @typedef {import("./stick.js").Stick} Stick */

const SLACK = 0.12; // dead zone: a resting thumb trembles

export class Touch {
  /** @type {Stick} */
  #stick = CENTRED;
  #finger = -1;
  #grabs = 0;
  #backward = false;
  #used = false;
  #reachPx = 1; // from the centre to full speed: as far as the ring that is drawn
  /** @type {() => void} */
  #onChange;
  /** @type {HTMLElement} */
  #knob;
  /** @type {HTMLElement} */
  #backwardButton;

  /**
   * @param {{zone: HTMLElement, knob: HTMLElement, grab: HTMLElement, backward: HTMLElement}} parts
   * @param {() => void} onChange
   */
  constructor(parts, onChange) {
    this.#onChange = onChange;
    this.#knob = parts.knob;
    this.#backwardButton = parts.backward;
    this.#followThumb(parts.zone);
    onPress(parts.grab, {
      press: () => {
        this.#grabs += 1;
        this.#touched();
      },
    });
    onPress(parts.backward, {
      press: () => this.#setBackward(true),
      release: () => this.#setBackward(false),
      click: () => this.#setBackward(!this.#backward), // held until the next one
    });
  }

  /** @param {HTMLElement} zone */
  #followThumb(zone) {
    /** @type {Stick} */
    let centre = CENTRED;
    zone.addEventListener("pointerdown", (event) => {
      if (this.#finger !== -1) return;
      event.preventDefault();
      zone.setPointerCapture(event.pointerId);
      this.#finger = event.pointerId;
      centre = { x: event.clientX, y: event.clientY };
      this.#reachPx = Math.max(1, this.#knob.offsetWidth / 2);
      const box = zone.getBoundingClientRect();
      this.#knob.style.setProperty("--stick-x", `${event.clientX - box.left}px`);
      this.#knob.style.setProperty("--stick-y", `${event.clientY - box.top}px`);
      this.#knob.dataset.held = "true";
      this.#move(CENTRED);
    });
    zone.addEventListener("pointermove", (event) => {
      if (event.pointerId !== this.#finger) return;
      this.#move({ x: (event.clientX - centre.x) / this.#reachPx, y: (centre.y - event.clientY) / this.#reachPx });
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      zone.addEventListener(kind, (event) => {
        if (/** @type {PointerEvent} */ (event).pointerId === this.#finger) this.#letGo();
      });
    }
  }

  /** @param {Stick} stick */
  #move(stick) {
    const length = lengthOf(stick);
    const scale = length < SLACK ? 0 : 1 / Math.max(1, length);
    this.#stick = { x: stick.x * scale, y: stick.y * scale };
    this.#knob.style.setProperty("--knob-x", `${this.#stick.x * this.#reachPx}px`);
    this.#knob.style.setProperty("--knob-y", `${-this.#stick.y * this.#reachPx}px`);
    this.#touched();
  }

  #letGo() {
    this.#finger = -1;
    delete this.#knob.dataset.held;
    this.#move(CENTRED);
  }

  /** @param {boolean} held */
  #setBackward(held) {
    this.#backward = held;
    this.#backwardButton.setAttribute("aria-pressed", String(held));
    this.#touched();
  }

  #touched() {
    this.#used = true;
    this.#onChange();
  }

  /** A finger touched the page: this person plays by touch now. */
  wake() {
    this.#used = true;
  }

  /** The page lost the focus: releases everything. */
  release() {
    this.#grabs = 0;
    if (this.#backward) this.#setBackward(false);
    if (this.#finger !== -1) this.#letGo();
  }

  /** Whether it was touched since the last reading. */
  get used() {
    return this.#used;
  }

  /** @returns {Reading} */
  read() {
    const reading = { stick: this.#stick, backward: this.#backward, grabs: this.#grabs, pings: 0 };
    this.#grabs = 0;
    this.#used = false;
    return reading;
  }
}
