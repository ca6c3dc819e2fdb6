// @ts-check
/*
 * The languages of the pages and which one a reader gets. A language is a file web/words/<language>.json and a line
 * in LANGUAGES.
 */

/** Every language by its own name. @type {Readonly<Record<string, string>>} */
export const LANGUAGES = Object.freeze({ en: "English", de: "Deutsch" });
export const DEFAULT_LANGUAGE = "en";
const KEY = "movingout.language";

/** The language without its country. @param {string | null | undefined} language */
function baseOf(language) {
  return language?.split("-")[0];
}

/** Whether the pages have its words: those of "de" for "de-AT". @param {string} language */
export function hasWords(language) {
  return Object.keys(LANGUAGES).some((known) => baseOf(known) === baseOf(language));
}

/** @param {string} language @returns {string} its name for its speakers */
export function languageName(language) {
  return LANGUAGES[language] ?? new Intl.DisplayNames(language, { type: "language" }).of(language) ?? language;
}

/**
 * The first wanted language that is offered, else the first offered: "de-AT" finds "de", and "de" finds "de-AT".
 * @param {readonly string[]} offered
 * @param {readonly (string | null | undefined)[]} wanted
 */
export function pickLanguage(offered, wanted) {
  for (const wish of wanted) {
    const found =
      offered.find((language) => language === wish) ??
      offered.find((language) => language === baseOf(wish)) ??
      offered.find((language) => baseOf(language) === baseOf(wish));
    if (found !== undefined) return found;
  }
  return offered[0];
}

/**
 * What the reader wishes, the strongest wish first: the address (`?lang=de`), also that of an earlier page in this tab,
 * the choice made before, the browser.
 * @returns {(string | null)[]}
 */
export function wishedLanguages() {
  const [address, ...browser] = browserLanguages();
  return [tabLanguage(address), keptLanguage(), ...browser];
}

/**
 * What the address asks for, which the tab keeps: a link with ?lang=de leads on to pages without it.
 * @param {string | null} asked
 */
function tabLanguage(asked) {
  try {
    if (asked !== null) sessionStorage.setItem(KEY, asked);
    return asked ?? sessionStorage.getItem(KEY);
  } catch {
    return asked; // storage is forbidden
  }
}

/**
 * Those of the address and the browser, without what was chosen before, perhaps by somebody else.
 * @returns {(string | null)[]}
 */
export function browserLanguages() {
  return [new URLSearchParams(location.search).get("lang"), ...navigator.languages];
}

/** The language of a page whose reader may choose freely. */
export function readerLanguage() {
  return pickLanguage([DEFAULT_LANGUAGE, ...Object.keys(LANGUAGES)], wishedLanguages());
}

/** @returns {string | null} what the reader chose before */
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
    sessionStorage.removeItem(KEY); // of an address before
    localStorage.setItem(KEY, language);
  } catch {
    // chosen for this page only
  }
}
