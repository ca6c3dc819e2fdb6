// @ts-check
/* The catalogues for tests, which have no server to load them from. */

import { readFileSync } from "node:fs";

import { setTexts } from "../../text/catalogue.js";

const WORDS = new URL("../../words/", import.meta.url);

/** @param {string} language @returns {Record<string, string>} */
export function textsOf(language) {
  return JSON.parse(readFileSync(new URL(`${language}.json`, WORDS), "utf-8"));
}

/** Lets `say` speak a language in this process. @param {string} language */
export function speak(language) {
  setTexts(language, textsOf(language));
}
