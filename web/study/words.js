// @ts-check
/*
 * What the study pages say, in the reader's language: web/words/study.<language>.json, one text per key, with
 * places for values in braces. Another language is another file and a line in LANGUAGES.
 */

import { ApiError, requestJson } from "../core/api.js";

export const LANGUAGES = /** @type {const} */ (["en", "de"]);
const KEY = "movingout-study-language";

export class Words {
  /** @param {string} language @param {Record<string, string>} texts */
  constructor(language, texts) {
    this.language = language;
    this.texts = texts;
  }

  /** @param {string} key @returns {boolean} */
  has(key) {
    return key in this.texts;
  }

  /** @param {string} key @param {Record<string, string | number>} [values] */
  say(key, values = {}) {
    const text = this.texts[key];
    if (text === undefined) throw new Error(`no text for ${key} in ${this.language}`);
    return text.replace(/\{(\w+)\}/g, (_, name) => String(values[name] ?? ""));
  }

  /** A failure as a sentence: our own where there is one, else the server's. @param {unknown} error */
  problem(error) {
    if (!(error instanceof ApiError)) throw error;
    return this.has(`error.${error.code}`) ? this.say(`error.${error.code}`) : error.message;
  }

  /** 65 seconds -> "1:05". @param {number} seconds */
  clock(seconds) {
    const whole = Math.max(0, Math.round(seconds));
    return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
  }
}

/** @param {string} language one of LANGUAGES @returns {Promise<Words>} */
export async function loadWords(language) {
  return new Words(language, await requestJson(`/static/words/study.${language}.json`));
}

/**
 * The first wanted language that is offered, else the first offered: "de-AT" finds "de".
 * @param {readonly string[]} offered @param {readonly (string | null | undefined)[]} wanted
 */
export function pickLanguage(offered, wanted) {
  for (const wish of wanted) {
    const found =
      offered.find((language) => language === wish) ?? offered.find((language) => language === wish?.split("-")[0]);
    if (found !== undefined) return found;
  }
  return offered[0];
}

/** @returns {string | null} what the reader chose on an earlier screen */
export function keptLanguage() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

/** @param {string} language */
export function keepLanguage(language) {
  try {
    localStorage.setItem(KEY, language);
  } catch {
    // chosen for this page only
  }
}
