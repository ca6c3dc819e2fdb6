// @ts-check
/*
 * What a screen is put together from: its heading, a button that asks the server for something, and the place where
 * it says what went wrong.
 */

import { el, notice } from "../core/dom.js";
import { sayError } from "../text/catalogue.js";

/** The title of a screen, which takes the focus when it opens. @param {string} text @param {string} [above] */
export function heading(text, above = "") {
  const line = above ? el("p", { class: "muted" }, above) : null;
  return el("div", { class: "heading" }, line, el("h1", { tabindex: "-1" }, text));
}

/** A place for what went wrong. @returns {HTMLElement} */
export function problemBox() {
  return el("div", { class: "problem", role: "alert" });
}

/** @param {HTMLElement} box @param {string} sentence empty: nothing is wrong */
export function showProblem(box, sentence) {
  box.replaceChildren(...(sentence ? [notice("bad", sentence)] : []));
}

/**
 * A button that runs an action; see `runAction`.
 * @param {string} text
 * @param {HTMLElement} problem
 * @param {() => Promise<void>} action
 * @param {string} [kind] "primary", "danger" or ""
 */
export function actionButton(text, problem, action, kind = "primary") {
  const button = el("button", { type: "button", class: kind ? `button button-${kind}` : "button" }, text);
  button.addEventListener("click", () => void runAction(button, problem, action));
  return button;
}

/**
 * Runs an action once at a time: the button rests meanwhile, and a refusal is shown in `problem`.
 * @param {HTMLButtonElement} button
 * @param {HTMLElement} problem
 * @param {() => Promise<void>} action rejects with an ApiError
 */
export async function runAction(button, problem, action) {
  if (button.getAttribute("aria-disabled") === "true") return;
  button.setAttribute("aria-disabled", "true"); // not `disabled`: the keyboard would lose its place
  showProblem(problem, "");
  try {
    await action();
  } catch (error) {
    showProblem(problem, sayError(error));
  } finally {
    button.removeAttribute("aria-disabled");
  }
}
