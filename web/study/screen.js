// @ts-check
/*
 * What the screens of a study have in common: what they may ask for, their card, and text that the server has rendered.
 */

import { el } from "../core/dom.js";

/** @typedef {import("./service.js").Step} Step */
/** @typedef {import("./service.js").Place} Place */
/**
 * What a screen may use and ask for.
 * @typedef {object} Context
 * @property {Step} step of the person, or of the first of both
 * @property {Step[]} steps of everybody whose screen this is
 * @property {number[]} people whose screen this is
 * @property {boolean} several two people sit here
 * @property {Place} place of the person, or of the first of both
 * @property {(given?: Record<string, unknown>) => Promise<void>} next on to the next step; rejects with an ApiError
 * @property {() => Promise<void>} decline
 * @property {() => void} play go to the room of this round
 * @property {(() => void) | null} addPerson asks the second person in, where that is offered
 * @property {() => void} leaveScreen nobody sits here any more
 * @property {(() => void) | null} nextCode shows the other person's code
 * @property {() => void} refresh asks the server at once
 */
/**
 * @typedef {object} Screen
 * @property {HTMLElement} root with an h1
 * @property {(step: Step) => void} [update] news of the same step
 * @property {() => void} [close] it is replaced
 */

/** A card with everything of a screen, one below the other. @param {...(Node | null | undefined)} parts */
export function card(...parts) {
  return el("section", { class: "card card-roomy study-card" }, ...parts);
}

/**
 * Markdown that the server rendered to safe HTML; the content security policy forbids scripts besides.
 * @param {string} html
 */
export function prose(html) {
  const box = el("div", { class: "prose" });
  box.innerHTML = html;
  box.querySelector("h1")?.setAttribute("tabindex", "-1");
  return box;
}
