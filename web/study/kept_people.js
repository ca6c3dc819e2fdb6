// @ts-check
/*
 * What this browser keeps of the people at a study's screen: the tokens of one or two, in localStorage, so that a
 * reload or another tab returns to the same places, and the link that somebody came by.
 */

const KEYS = ["movingout-study-token", "movingout-study-token-2"];
const LINK = "movingout-study-link";
const BY_LINK = "movingout-study-by-link"; // a link meant for them alone, so this is probably a device of their own

/** @returns {boolean} whether the person here followed a link that named them */
export function cameByLink() {
  try {
    return localStorage.getItem(BY_LINK) !== null;
  } catch {
    return false;
  }
}

/** @param {boolean} byLink */
export function keepByLink(byLink) {
  try {
    if (byLink) localStorage.setItem(BY_LINK, "1");
    else localStorage.removeItem(BY_LINK);
  } catch {
    // without storage the last screen offers one button too many
  }
}

/**
 * The parameters of the link that somebody came by: until they have consented a mended study may ask them again, and
 * the address bar has them no more. In this tab alone.
 * @param {Record<string, string>} parameters empty where there are none to keep
 */
export function keepLink(parameters) {
  try {
    if (Object.keys(parameters).length > 0) sessionStorage.setItem(LINK, JSON.stringify(parameters));
    else sessionStorage.removeItem(LINK);
  } catch {
    // without storage they have to open their link again
  }
}

/** @returns {Record<string, string> | null} */
export function loadLink() {
  try {
    return JSON.parse(sessionStorage.getItem(LINK) ?? "null");
  } catch {
    return null;
  }
}

/** @returns {string[]} the kept tokens, the first person's first */
export function loadPeople() {
  try {
    return KEYS.map((key) => localStorage.getItem(key)).filter((token) => token !== null);
  } catch {
    return [];
  }
}

/** @param {readonly string[]} tokens empty when nobody sits here any more */
export function savePeople(tokens) {
  try {
    KEYS.forEach((key, person) =>
      tokens[person] ? localStorage.setItem(key, tokens[person]) : localStorage.removeItem(key),
    );
  } catch {
    // without storage the places last until the page is closed; the link leads back to them
  }
}
