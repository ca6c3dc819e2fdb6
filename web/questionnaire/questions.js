// @ts-check
/*
 * The questions of a form: 7-point scale, NASA-TLX line, choice and free text. Native radios, a native range and a
 * textarea, so that keyboard, screen reader and finger all use the same control.
 */

import { el } from "../core/dom.js";
import { LIKERT_MAX, LIKERT_MIN } from "../messages.js";
import { say } from "../text/catalogue.js";
import { freeText } from "./free_text.js";
import { endsOf, idOf, noAnswer, radio } from "./radio.js";
import { tlxScale } from "./tlx_scale.js";

/** @typedef {import("./pages.js").Item} Item */
/** @typedef {import("./pages.js").Given} Given */
/** @typedef {import("./radio.js").Save} Save */
/** @typedef {{root: HTMLElement, flush: () => void}} Question `flush` saves what is still being typed */

const LIKERT = Array.from({ length: LIKERT_MAX - LIKERT_MIN + 1 }, (_, step) => LIKERT_MIN + step);

/** @param {Item} item @param {Given | undefined} given @param {Save} save @returns {Question} */
export function question(item, given, save) {
  if (item.kind === "text") return freeText(item, given, save);
  const body = { likert7: likert, tlx: tlxScale, choice }[item.kind](item, given?.value, save);
  const root = el(
    "fieldset",
    { class: "question", id: idOf(item), "aria-describedby": `${idOf(item)}-missing` },
    el("legend", {}, item.text),
    ...body,
    el("p", { class: "question-missing", id: `${idOf(item)}-missing` }, say("form.missingHere")),
  );
  return { root, flush: () => {} };
}

/** @param {Item} item @param {number | undefined} value @param {Save} save */
function likert(item, value, save) {
  const [low, high] = endsOf(item);
  const id = idOf(item);
  const boxes = LIKERT.map((step) => {
    const end = step === LIKERT[0] ? `${id}-low` : step === LIKERT.at(-1) ? `${id}-high` : null;
    const input = radio(item, step, value, save, end);
    return el("label", { class: "choice-option likert-option" }, input, el("span", {}, String(step)));
  });
  const ends = el(
    "div",
    { class: "scale-ends" },
    el("span", { id: `${id}-low` }, low),
    noAnswer(item, value, save),
    el("span", { id: `${id}-high` }, high),
  );
  return [el("div", { class: "likert" }, ...boxes), ends];
}

/** @param {Item} item @param {number | undefined} value @param {Save} save */
function choice(item, value, save) {
  const options = (item.options ?? []).map((text, index) =>
    el("label", { class: "choice-option" }, radio(item, index, value, save), el("span", {}, text)),
  );
  return [el("div", { class: "choice" }, ...options), noAnswer(item, value, save)];
}
