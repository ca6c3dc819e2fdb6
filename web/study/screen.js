// @ts-check
/*
 * What the screens of a study have in common: the heading that takes the focus, the one way on with its complaint,
 * and text that the server has rendered.
 */

import { el, notice } from "../core/dom.js";
import { sayError } from "../text/catalogue.js";

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

/** @param {string} text @param {string} [kicker] what stands above it @returns {HTMLElement} */
export function heading(text, kicker = "") {
  const above = kicker ? el("p", { class: "muted" }, kicker) : null;
  return el("div", { class: "study-head" }, above, el("h1", { tabindex: "-1" }, text));
}

/** A card with everything of a screen, one below the other. @param {...(Node | null | undefined)} parts */
export function card(...parts) {
  return el("section", { class: "card card-roomy study-card" }, ...parts);
}

/** A place for what went wrong. @returns {HTMLElement} */
export function problemBox() {
  return el("div", { class: "study-problem", role: "alert" });
}

/** @param {HTMLElement} box @param {string} sentence empty: all is well */
export function complain(box, sentence) {
  box.replaceChildren(...(sentence ? [notice("bad", sentence)] : []));
}

/**
 * A button that does something with the server: it rests while that runs, and says what went wrong.
 * @param {string} text @param {HTMLElement} problem @param {() => Promise<void>} action
 * @param {string} [kind] "primary", "danger" or ""
 */
export function actionButton(text, problem, action, kind = "primary") {
  const button = el("button", { type: "button", class: kind ? `button button-${kind}` : "button" }, text);
  button.addEventListener("click", () => void attempt(button, problem, action));
  return button;
}

/**
 *
 * @param {HTMLButtonElement} button
 * @param {HTMLElement} problem
 * @param {() => Promise<void>} action
 */
export async function attempt(button, problem, action) {
  if (button.getAttribute("aria-disabled") === "true") return;
  button.setAttribute("aria-disabled", "true"); // not `disabled`: the keyboard would lose its place
  complain(problem, "");
  try {
    await action();
  } catch (error) {
    complain(problem, sayError(error));
  } finally {
    button.removeAttribute("aria-disabled");
  }
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
