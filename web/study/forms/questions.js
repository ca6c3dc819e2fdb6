// @ts-check
/*
 * The widgets of a form: 7-point scale, NASA-TLX line, choice and text. Native radios, a native range and a textarea:
 * keyboard, screen reader and finger meet the same thing. They know nothing of saving: `save` gets each answer.
 */

import { el } from "../../core/dom.js";
import { say } from "../../text/catalogue.js";

/** @typedef {import("../service.js").Item} Item */
/** @typedef {import("./questionnaire_pages.js").Given} Given */
/** @typedef {(item: Item, value: number, text: string) => void} Save */
/** @typedef {{root: HTMLElement, flush: () => void}} Question `flush` saves what is still being typed */

export const NO_ANSWER = -1; // study/questionnaire.py
const LIKERT = [1, 2, 3, 4, 5, 6, 7];
const TLX_MOST = 20;
const TEXT_LIMIT = 4000; // study/questionnaire.py
const TYPING_MS = 700; // a text is saved this long after the last key

/** @param {Item} item @param {Given | undefined} given @param {Save} save @returns {Question} */
export function question(item, given, save) {
  if (item.kind === "text") return textQuestion(item, given, save);
  const body = { likert7: likert, tlx, choice }[item.kind](item, given?.value, save);
  const root = el(
    "fieldset",
    { class: "question", id: idOf(item), "aria-describedby": `${idOf(item)}-missing` },
    el("legend", {}, item.text),
    ...body,
    el("p", { class: "question-missing", id: `${idOf(item)}-missing` }, say("form.missingHere")),
  );
  return { root, flush: () => {} };
}

/** @param {Item} item */
export function idOf(item) {
  return `question-${item.id}`;
}

/** @param {Item} item @returns {[string, string]} */
function endsOf(item) {
  const usual = /** @type {[string, string]} */ ([say("form.low"), say("form.high")]);
  return item.ends ?? usual;
}

/** @param {Item} item @param {number | undefined} value @param {Save} save */
function likert(item, value, save) {
  const [low, high] = endsOf(item);
  const id = idOf(item);
  const boxes = LIKERT.map((step) => {
    const end = step === LIKERT[0] ? `${id}-low` : step === LIKERT.at(-1) ? `${id}-high` : null;
    return el("label", { class: "likert-option" }, radio(item, step, value, save, end), el("span", {}, String(step)));
  });
  const ends = el(
    "div",
    { class: "likert-ends" },
    el("span", { id: `${id}-low` }, low),
    noAnswer(item, value, save),
    el("span", { id: `${id}-high` }, high),
  );
  return [el("div", { class: "likert" }, ...boxes), ends];
}

/**
 * @param {Item} item
 * @param {number} value
 * @param {number | undefined} given
 * @param {Save} save
 * @param {string | null} [describedBy]
 */
function radio(item, value, given, save, describedBy = null) {
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

/** @param {Item} item @param {number | undefined} given @param {Save} save */
function noAnswer(item, given, save) {
  return el("label", { class: "no-answer" }, radio(item, NO_ANSWER, given, save), el("span", {}, say("form.noAnswer")));
}

/** @param {Item} item @param {number | undefined} value @param {Save} save */
function choice(item, value, save) {
  const options = (item.options ?? []).map((text, index) =>
    el("label", { class: "choice-option" }, radio(item, index, value, save), el("span", {}, text)),
  );
  return [el("div", { class: "choice" }, ...options), noAnswer(item, value, save)];
}

/**
 * Twenty-one gradations; nothing is chosen until the handle was touched.
 *
 * @param {Item} item
 * @param {number | undefined} value
 * @param {Save} save
 */
function tlx(item, value, save) {
  const [low, high] = endsOf(item);
  const chosen = value !== undefined && value !== NO_ANSWER;
  const said = el("output", { class: "tlx-said muted small" });
  const range = el("input", {
    type: "range",
    class: "tlx",
    min: 0,
    max: TLX_MOST,
    step: 1,
    value: chosen ? value : TLX_MOST / 2,
    "aria-label": `${item.text} ${low} – ${high}`,
    "data-chosen": String(chosen),
  });
  const no = noAnswer(item, value, (_, answer, text) => {
    mark(false);
    save(item, answer, text);
  });
  const mark = (/** @type {boolean} */ set) => {
    range.dataset.chosen = String(set);
    said.textContent = say(set ? "form.chosen" : "form.choose", { value: range.value, most: TLX_MOST });
    range.setAttribute("aria-valuetext", said.textContent);
  };
  const choose = () => {
    mark(true);
    const none = no.querySelector("input");
    if (none) none.checked = false;
    save(item, Number(range.value), "");
  };
  range.addEventListener("input", () => mark(true));
  range.addEventListener("change", choose);
  // A click on the handle where it stands, or Space, says "right there".
  range.addEventListener("click", () => range.dataset.chosen === "false" && choose());
  range.addEventListener("keydown", (event) => event.key === " " && choose());
  mark(chosen);
  const ends = el("div", { class: "likert-ends" }, el("span", {}, low), no, el("span", {}, high));
  return [said, range, ends];
}

/** @param {Item} item @param {Given | undefined} given @param {Save} save @returns {Question} */
function textQuestion(item, given, save) {
  const id = idOf(item);
  const area = el("textarea", {
    id: `${id}-text`,
    class: "input",
    rows: 6,
    maxlength: TEXT_LIMIT,
    "aria-describedby": `${id}-help ${id}-missing`,
  });
  let saved = given?.text ?? "";
  area.value = saved;
  let timer = 0;
  const flush = () => {
    window.clearTimeout(timer);
    if (area.value === saved) return;
    saved = area.value;
    save(item, NO_ANSWER, saved);
  };
  area.addEventListener("input", () => {
    window.clearTimeout(timer);
    timer = window.setTimeout(flush, TYPING_MS);
  });
  area.addEventListener("change", flush);
  const root = el(
    "div",
    { class: "field question", id },
    el("label", { for: `${id}-text` }, item.text),
    el("p", { id: `${id}-help`, class: "field-help" }, say(item.required ? "form.textHelpRequired" : "form.textHelp")),
    area,
    el("p", { class: "question-missing", id: `${id}-missing` }, say("form.missingText")),
  );
  return { root, flush };
}
