// @ts-check
/*
 * The NASA-TLX line: 21 gradations, as on the paper form. Nothing is chosen until the handle has been touched.
 */

import { el } from "../core/dom.js";
import { NO_ANSWER, TLX_MAX } from "../messages.js";
import { say } from "../text/catalogue.js";
import { endsOf, noAnswer } from "./radio.js";

/** @typedef {import("./pages.js").Item} Item */
/** @typedef {import("./radio.js").Save} Save */

/**
 * @param {Item} item
 * @param {number | undefined} value chosen before
 * @param {Save} save
 * @returns {HTMLElement[]}
 */
export function tlxScale(item, value, save) {
  const [low, high] = endsOf(item);
  const chosen = value !== undefined && value !== NO_ANSWER;
  const state = el("output", { class: "tlx-state muted small" });
  const range = rangeInput(`${item.text} ${low} – ${high}`, chosen ? value : TLX_MAX / 2);
  const mark = (/** @type {boolean} */ set) => {
    range.dataset.chosen = String(set);
    state.textContent = say(set ? "form.chosen" : "form.choose", { value: range.value, most: TLX_MAX });
    range.setAttribute("aria-valuetext", state.textContent);
  };
  const none = noAnswer(item, value, (_, answer, text) => {
    mark(false);
    save(item, answer, text);
  });
  onChoice(range, mark, () => {
    const radio = none.querySelector("input");
    if (radio) radio.checked = false;
    save(item, Number(range.value), "");
  });
  mark(chosen);
  const ends = el("div", { class: "scale-ends" }, el("span", {}, low), none, el("span", {}, high));
  return [state, el("div", { class: "tlx-line" }, ticks(), range), ends];
}

/** @param {string} label @param {number} value */
function rangeInput(label, value) {
  return el("input", { type: "range", class: "tlx", min: 0, max: TLX_MAX, step: 1, value, "aria-label": label });
}

/**
 * Every way to choose: dragging, a key, and a click or Space that confirms the handle where it stands.
 * @param {HTMLInputElement} range
 * @param {(set: boolean) => void} mark
 * @param {() => void} chosen
 */
function onChoice(range, mark, chosen) {
  const choose = () => {
    mark(true);
    chosen();
  };
  range.addEventListener("input", () => mark(true));
  range.addEventListener("change", choose);
  for (const confirm of ["click", "pointerup"])
    // a finger on the handle makes no click
    range.addEventListener(confirm, () => range.dataset.chosen === "false" && choose());
  range.addEventListener("keydown", (event) => event.key === " " && choose());
}

/** One mark per gradation. Elements, not a gradient: the browser gives each the same whole number of pixels. */
function ticks() {
  const marks = Array.from({ length: TLX_MAX + 1 }, () => el("span"));
  return el("div", { class: "tlx-ticks", "aria-hidden": "true" }, ...marks);
}
