// Pause, go on, or ask whether to stop: by the button and the key for it, a gamepad, or because a dialog opens.

import { codeOf } from "../input/keyboard_layout.js";
import { PAUSE_KEYS } from "../input/mapping.js";

/**
 * @typedef {object} PausePage what pausing needs of the page
 * @property {import("./game.js").Game} game
 * @property {import("./panels.js").Panels} panels
 * @property {(seat: number) => void} pause asks the server
 * @property {(seat: number) => void} ready
 * @property {() => boolean} dialogIsOpen
 */

export class PauseControl {
  #askedFor = false; // the last pause was asked for by its button or key
  #page;

  /** @param {PausePage} page */
  constructor(page) {
    this.#page = page;
  }

  /** The server refuses: without a pause there is no panel with the button that stops, so who wanted it is asked. */
  refused() {
    if (this.#askedFor) this.#page.panels.askStop();
  }

  /** The button was pressed. */
  pauseOrStop() {
    if (this.#page.game.phase === "playing") this.toggle(true);
    else this.#page.panels.askStop();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { panels, dialogIsOpen } = this.#page;
    const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
    const isShortcut = event.ctrlKey || event.metaKey || event.altKey; // of the browser: Ctrl and P prints
    if (!PAUSE_KEYS.includes(codeOf(event)) || isShortcut || event.repeat || typing || dialogIsOpen()) return;
    if (!panels.refuseStop()) this.toggle(true);
  }

  /** @param {boolean} asked by the button or key for it, which also lead to stopping @param {number} [seat] whose */
  toggle(asked, seat = this.#page.game.own[0]) {
    this.#askedFor = asked;
    if (seat === undefined) return;
    if (this.#page.game.phase === "playing") this.#page.pause(seat);
    else if (this.#page.game.phase === "paused") this.#page.ready(seat);
  }
}
