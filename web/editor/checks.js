// @ts-check
/*
 * Asks the server whether the map can be played, a moment after each change, and shows what it says. The newest
 * question counts: what is answered late is left aside.
 */

import { ApiError, requestJson } from "../core/api.js";
import { byId, el } from "../core/dom.js";
import { say, sayError } from "../text/catalogue.js";
import { faultText, missing } from "./faults.js";
import { partAt } from "./parts.js";

/** @typedef {import("./faults.js").Fault} Fault */
/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */

const WAIT_MS = 350;
const AGAIN_MS = 5000; // after a refusal

/**
 * @param {unknown} map any JSON document
 * @param {AbortSignal} [signal]
 * @returns {Promise<{map: GameMap | null, faults: Fault[], hints: Fault[]}>} the map as it was read; null where it
 *   could not be. Hints keep nothing from being played.
 */
export function askServer(map, signal) {
  return requestJson("/api/editor/check", { body: { map }, ...(signal && { signal }) });
}

export class Checks {
  /** @param {(part: Part) => void} onChoose @param {() => void} onChange */
  constructor(onChoose, onChange) {
    /** @type {Fault[]} */
    this.faults = [];
    this.known = false; // whether `faults` are those of the map as it is
    this.answered = false; // whether there was an answer at all
    this.onChoose = onChoose;
    this.onChange = onChange;
    this.timer = 0;
    this.asking = new AbortController();
  }

  /** Whether the map can be played, as far as is known: the server looks again before it does anything with it. */
  get sound() {
    return this.answered && this.faults.length === 0;
  }

  /** @param {GameMap} map @param {number} [wait] */
  begin(map, wait = WAIT_MS) {
    window.clearTimeout(this.timer);
    this.asking.abort();
    this.known = false;
    const lacking = missing(map);
    if (lacking.length > 0) return this.#found(lacking);
    this.timer = window.setTimeout(() => void this.#ask(map), wait);
  }

  /** @param {GameMap} map */
  async #ask(map) {
    this.asking = new AbortController();
    const { signal } = this.asking;
    try {
      const { faults, hints } = await askServer(map, signal);
      if (!signal.aborted) this.#found(faults, hints);
    } catch (error) {
      if (signal.aborted) return;
      if (!(error instanceof ApiError)) throw error;
      this.#say("attention", sayError(error));
      this.timer = window.setTimeout(() => void this.#ask(map), AGAIN_MS);
    }
  }

  /** Hints wait until nothing keeps the map from being played. @param {Fault[]} faults @param {Fault[]} [hints] */
  #found(faults, hints = []) {
    this.faults = faults;
    this.known = this.answered = true;
    if (faults.length > 0) this.#say("attention", say("editor.faults", { count: faults.length }));
    else this.#say("ok", say(hints.length > 0 ? "editor.hints" : "editor.sound"));
    const told = faults.length > 0 ? faults : hints;
    byId("faults", HTMLElement).replaceChildren(...told.map((fault) => el("li", {}, this.#line(fault))));
    this.onChange();
  }

  /** @param {Fault} fault */
  #line(fault) {
    const part = partAt(fault.path);
    if (part === null) return el("span", {}, faultText(fault));
    return el(
      "button",
      { type: "button", class: "button-link editor-fault", onclick: () => this.onChoose(part) },
      faultText(fault),
    );
  }

  /** @param {string} kind @param {string} text */
  #say(kind, text) {
    const verdict = byId("verdict", HTMLElement);
    verdict.className = `notice notice-${kind}`;
    if (verdict.textContent !== text) verdict.textContent = text; // said anew only where it is news
  }
}
