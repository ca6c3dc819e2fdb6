// @ts-check
/*
 * The storage of this browser. Where a reader forbids cookies and site data, or another site embeds the page, even to
 * name it throws.
 */

import { ApiError } from "./api.js";

/** @typedef {Pick<Storage, "getItem" | "setItem">} Kept */

/** @type {Map<string, string>} */
const texts = new Map();
/** @type {Kept} */
const OF_THIS_PAGE = {
  getItem: (key) => texts.get(key) ?? null,
  setItem: (key, text) => void texts.set(key, text),
};

/** @returns {Kept} localStorage; where it is forbidden, one that lasts as long as the page */
export function lastingStorage() {
  try {
    return localStorage;
  } catch {
    return OF_THIS_PAGE;
  }
}

/** What goes on in another page finds its seats in the storage. Throws an ApiError where that is forbidden. */
export function requireStorage() {
  try {
    void [localStorage, sessionStorage];
  } catch {
    throw new ApiError("storage", "This browser may not keep data for this page.", 0);
  }
}
