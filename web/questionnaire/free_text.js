// @ts-check
/*
 * A question answered in one's own words, saved while it is being typed.
 */

import { el } from "../core/dom.js";
import { NO_ANSWER, TEXT_LIMIT } from "../messages.js";
import { say } from "../text/catalogue.js";
import { idOf } from "./radio.js";

/** @typedef {import("./pages.js").Item} Item */
/** @typedef {import("./pages.js").Given} Given */
/** @typedef {import("./radio.js").Save} Save */

const TYPING_MS = 700; // a text is saved this long after the last key

/**
 * @param {Item} item
 * @param {Given | undefined} given
 * @param {Save} save
 * @returns {import("./questions.js").Question}
 */
export function freeText(item, given, save) {
  const id = idOf(item);
  const area = el("textarea", {
    id: `${id}-text`,
    class: "input",
    rows: 6,
    maxlength: TEXT_LIMIT,
    "aria-describedby": `${id}-help ${id}-missing`,
  });
  area.value = given?.text ?? "";
  const flush = saveWhileTyping(area, (text) => save(item, NO_ANSWER, text));
  const full = fullness(area);
  const usual = say(item.required ? "form.textHelpRequired" : "form.textHelp", { most: TEXT_LIMIT });
  const help = given?.hidden ? `${usual} ${say("form.textElsewhere")}` : usual;
  const root = el(
    "div",
    { class: "field question", id },
    el("label", { for: `${id}-text` }, item.text),
    el("p", { id: `${id}-help`, class: "field-help" }, help),
    area,
    full,
    el("p", { class: "question-missing", id: `${id}-missing` }, say("form.missingText")),
  );
  return { root, flush };
}

/**
 * What is said once nothing more fits: the browser cuts off what is pasted, without a word.
 * @param {HTMLTextAreaElement} area
 */
function fullness(area) {
  const said = el("p", { class: "field-help", "aria-live": "polite" });
  const look = () => {
    said.textContent = area.value.length < TEXT_LIMIT ? "" : say("form.textFull", { most: TEXT_LIMIT });
  };
  area.addEventListener("input", look);
  look();
  return said;
}

/**
 * @param {HTMLTextAreaElement} area
 * @param {(text: string) => void} save
 * @returns {() => void} saves now what was not saved yet
 */
function saveWhileTyping(area, save) {
  let saved = area.value;
  let timer = 0;
  const flush = () => {
    window.clearTimeout(timer);
    if (area.value === saved) return;
    saved = area.value;
    save(saved);
  };
  area.addEventListener("input", () => {
    window.clearTimeout(timer);
    timer = window.setTimeout(flush, TYPING_MS);
  });
  area.addEventListener("change", flush);
  return flush;
}
