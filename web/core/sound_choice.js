// @ts-check
/*
 * Whether somebody has switched the sounds off in this browser.
 */

import { lastingStorage } from "./browser_storage.js";

const KEY = "movingout-sound";

/** @returns {boolean} */
export function wantsSound() {
  try {
    return lastingStorage().getItem(KEY) !== "off";
  } catch {
    return true;
  }
}

/** @param {boolean} wanted */
export function keepSound(wanted) {
  try {
    lastingStorage().setItem(KEY, wanted ? "on" : "off");
  } catch {
    // without storage the choice lasts as long as the page
  }
}

/** @param {Pick<Storage, "removeItem">} storage */
export function forgetSound(storage) {
  storage.removeItem(KEY);
}
