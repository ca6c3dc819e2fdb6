// @ts-check
/*
 * Who judges: a name that is asked for once and kept in this browser.
 */

import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";

const KEY = "movingout.annotator";
const NAME = "[\\p{L}\\p{N}_][\\p{L}\\p{M}\\p{N}_ .'’`´·\\-]{0,39}"; // recordings/annotation/verdicts.py

/** The name that is kept, "" for none and for one that the server would refuse. */
export function keptName() {
  try {
    const kept = localStorage.getItem(KEY) ?? "";
    return new RegExp(`^(?:${NAME})$`, "u").test(kept) ? kept : "";
  } catch {
    return "";
  }
}

export function forgetName() {
  try {
    localStorage.removeItem(KEY);
  } catch {
    // it was not kept
  }
}

/** @param {HTMLElement} container where to ask @returns {Promise<string>} */
export function askName(container) {
  const input = el("input", {
    id: "annotator",
    class: "input",
    type: "text",
    autocomplete: "nickname",
    maxlength: 40,
    pattern: NAME,
    title: say("error.annotator"),
    required: true,
  });
  const form = el(
    "form",
    { class: "card card-roomy stack token-form" },
    el(
      "div",
      { class: "field" },
      el("label", { for: "annotator" }, say("annotate.name")),
      input,
      el("p", { class: "field-help" }, say("annotate.name.help")),
    ),
    el("button", { type: "submit", class: "button button-primary" }, say("annotate.begin")),
  );
  container.replaceChildren(
    el("h1", {}, say("annotate.title")),
    el("p", { class: "muted" }, say("annotate.lead")),
    form,
  );
  input.focus();
  return new Promise((done) => {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const name = input.value.trim();
      try {
        localStorage.setItem(KEY, name);
      } catch {
        // asked again after a reload
      }
      container.replaceChildren();
      done(name);
    });
  });
}
