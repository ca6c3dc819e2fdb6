// @ts-check
/*
 * What the pages say, in the reader's language: web/words/<language>.json has one text per key. A text has places for
 * values in braces; a text that depends on a count has one entry per plural form, `….one` and `….other`.
 *
 * A page calls `useLanguage` once before it shows anything; modules call `say` when they show something, never while
 * they are loaded.
 */

import { ApiError, requestJson } from "../core/api.js";
import { DEFAULT_LANGUAGE, LANGUAGES, pickLanguage } from "./language.js";

/** @typedef {Record<string, string>} Texts */
/** @typedef {Readonly<Record<string, unknown>>} Values numbers and lists are written as the language does */

const FROM_THE_RIGHT = /[\u0590-\u08ff\ufb1d-\ufdff\ufe70-\ufefc]/; // Hebrew, Arabic and the scripts between
const ISOLATE = "\u2068"; // first strong isolate, and the end of one
const END = "\u2069";

let language = DEFAULT_LANGUAGE;
/** @type {Texts} */
let texts = {};
let plural = new Intl.PluralRules(language);
let decimal = new Intl.NumberFormat(language);

/**
 * Loads a language, which all texts are in from then on. What it lacks is said in English.
 * @param {string} wanted a key of LANGUAGES, or one of a country: "de-AT" has the words of "de" and its own numbers
 */
export async function useLanguage(wanted) {
  const words = pickLanguage(Object.keys(LANGUAGES), [wanted]);
  const files = [...new Set([DEFAULT_LANGUAGE, words])].map((name) => requestJson(`/static/words/${name}.json`));
  setTexts(wanted, Object.assign({}, ...(await Promise.all(files))));
  document.documentElement.lang = wanted;
}

/** @param {string} name @param {Texts} newTexts */
export function setTexts(name, newTexts) {
  language = name;
  texts = newTexts;
  plural = new Intl.PluralRules(language);
  decimal = new Intl.NumberFormat(language);
}

/** The language that texts are in: "en", or "en-GB" in a study that has it. */
export function currentLanguage() {
  return language;
}

/** @param {string} key */
export function has(key) {
  return find(key, {}) !== undefined;
}

/**
 * The text of a key; `values.count` chooses the plural form where there is one.
 * @param {string} key
 * @param {Values} [values] by the names of the places
 */
export function say(key, values = {}) {
  const text = find(key, values);
  if (text === undefined) throw new Error(`no text for ${key} in ${language}`);
  return text.replace(/\{(\w+)\}/g, (_, name) => {
    const value = values[name];
    if (Array.isArray(value)) return new Intl.ListFormat(language).format(value.map((one) => isolated(String(one))));
    return typeof value === "number" ? decimal.format(value) : isolated(String(value ?? ""));
  });
}

/** A name as people write it, in its own direction within a sentence from left to right. @param {string} name */
export function isolated(name) {
  return FROM_THE_RIGHT.test(name) && !name.startsWith(ISOLATE) ? ISOLATE + name + END : name;
}

/** A text that is kept, without the marks of `isolated`. @param {string} text */
export function unmarked(text) {
  return text.replaceAll(ISOLATE, "").replaceAll(END, "");
}

/** @param {string} key @param {Values} values @returns {string | undefined} */
function find(key, { count }) {
  return texts[key] ?? (typeof count === "number" ? texts[`${key}.${plural.select(count)}`] : texts[`${key}.other`]);
}

/**
 * A number with a fixed count of decimals: 0.5 -> "0.50", in German "0,50".
 * @param {number} value @param {number} decimals
 */
export function sayNumber(value, decimals) {
  return new Intl.NumberFormat(language, {
    minimumFractionDigits: decimals,
    maximumFractionDigits: decimals,
    useGrouping: false,
  }).format(value);
}

/** A refusal as a sentence: the reader's by its code, else the server's own. @param {unknown} error */
export function sayError(error) {
  if (!(error instanceof ApiError)) throw error;
  const refusal = `refusal.${error.values.refusal}`; // why the server is full
  const key = has(refusal) ? refusal : `error.${error.code}`;
  return has(key) ? say(key, error.values) : error.message;
}

/**
 * Puts the texts into a page's HTML, where English stands until then: `data-say="key"` for the content of an element,
 * `data-say-<attribute>="key"` for an attribute, such as data-say-aria-label.
 * @param {ParentNode} [root]
 */
export function fillIn(root = document) {
  for (const element of root.querySelectorAll("*")) {
    for (const { name, value } of [...element.attributes]) {
      if (name === "data-say") element.textContent = say(value);
      else if (name.startsWith("data-say-")) element.setAttribute(name.slice("data-say-".length), say(value));
    }
  }
}
