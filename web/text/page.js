// @ts-check
/*
 * Starts a page in the reader's language: its texts are loaded and stand in its HTML when `prepareTexts` resolves.
 */

import { ApiError } from "../core/api.js";
import { fillIn, say, useLanguage } from "./catalogue.js";
import { readerLanguage } from "./language.js";

const RETRY_MS = 1000;

/** Tries until the server answers. @param {string} [language] as useLanguage takes it */
export async function prepareTexts(language = readerLanguage()) {
  for (;;) {
    try {
      await useLanguage(language);
      fillIn();
      addEventListener("movingout-theme", sayTheme);
      return;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      await new Promise((done) => setTimeout(done, RETRY_MS));
    }
  }
}

/** theme.js, which cannot wait for texts, leaves the key of its button's text. */
function sayTheme() {
  for (const button of document.querySelectorAll("[data-theme-button][data-say]"))
    button.textContent = say(button.getAttribute("data-say") ?? "");
}
