// @ts-check
/*
 * The native radio buttons that all scales and choices are made of. They know nothing of saving: `save` gets each
 * answer.
 */

import { el } from "../core/dom.js";
import { NO_ANSWER } from "../messages.js";
import { say } from "../text/catalogue.js";

/** @typedef {import("./pages.js").Item} Item */
/** @typedef {(item: Item, value: number, text: string) => void} Save */

/** The id of a question's element. @param {Item} item */
export function idOf(item) {
  return `question-${item.id}`;
}

/**
 * One radio button of a question.
 * @param {Item} item
 * @param {number} value
 * @param {number | undefined} given the value that was chosen before
 * @param {Save} save
 * @param {string | null} [describedBy]
 */
export function radio(item, value, given, save, describedBy = null) {
  const input = el("input", {
    type: "radio",
    name: item.id,
    value,
    checked: given === value,
    "aria-describedby": describedBy,
  });
  input.addEventListener("change", () => save(item, value, ""));
  return input;
}

/** "I prefer not to answer". @param {Item} item @param {number | undefined} given @param {Save} save */
export function noAnswer(item, given, save) {
  return el("label", { class: "no-answer" }, radio(item, NO_ANSWER, given, save), el("span", {}, say("form.noAnswer")));
}

/** What the two ends of a scale mean. @param {Item} item @returns {[string, string]} */
export function endsOf(item) {
  if (item.ends) return item.ends;
  return item.kind === "tlx" ? [say("form.tlxLow"), say("form.tlxHigh")] : [say("form.low"), say("form.high")];
}
