// @ts-check
/*
 * Common parts of the screens of a study: their context, their card, and text rendered by the server.
 */

import { el } from "../core/dom.js";

/** @typedef {import("./service.js").Step} Step */
/** @typedef {import("./service.js").Place} Place */
/** @typedef {Record<string, unknown>} Given what a step is answered with */
/**
 * What a step's screen knows that is lost on no change of the language.
 * @typedef {object} Kept
 * @property {Set<string>} [ticked] ids of a consent's boxes
 * @property {number} [page] of a form
 * @property {import("../core/elapsed.js").Elapsed} [since] when a break began
 * @property {import("./input_check/tried_controls.js").TriedControls[]} [tried] of an input check, by person
 */
/**
 * What a screen can read and do.
 * @typedef {object} Context
 * @property {Step} step of the person, or of the first of both
 * @property {Kept} kept
 * @property {Step[]} steps of everybody whose screen this is
 * @property {number[]} people whose screen this is
 * @property {boolean} several whether two people sit here
 * @property {Place} place of the person, or of the first of both
 * @property {(given?: Given | Given[]) => Promise<void>} next goes to the next step, with one entry for all of `people`
 *   or one for each; rejects with an ApiError
 * @property {() => Promise<void>} decline
 * @property {() => void} play goes to the room of this round
 * @property {(() => void) | null} addPerson lets a second person join, where that is offered
 * @property {"paid" | "unpaid"} pay whether the study pays
 * @property {(() => void) | null} leaveScreen forgets everybody at this screen; null where nobody else comes to it
 * @property {(() => void) | null} nextCode shows the other person's code
 * @property {() => void} refresh asks the server at once
 */
/**
 * @typedef {object} Screen
 * @property {HTMLElement} root with an h1
 * @property {(step: Step) => void} [update] takes an update of the same step
 * @property {() => void} [close] called when the screen is replaced
 */

/** The card of a screen, its parts one below the other. @param {...(Node | null | undefined)} parts */
export function card(...parts) {
  return el("section", { class: "card card-roomy study-card" }, ...parts);
}

/**
 * Markdown rendered by the server to safe HTML; the content security policy forbids scripts as well.
 * @param {string} html
 */
export function prose(html) {
  const box = el("div", { class: "prose" });
  box.innerHTML = html;
  box.querySelector("h1")?.setAttribute("tabindex", "-1");
  return box;
}
