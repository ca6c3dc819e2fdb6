// @ts-check
/*
 * What a browser keeps of the drawing: in localStorage the last one of all tabs, in sessionStorage that of this tab,
 * which may be of another map.
 */

import { keptMap } from "./history.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {{which: string, map: GameMap | null}} Kept  null: there is none, or it is no map */

export const MAP = "movingout.editor";
const WHICH = "movingout.editor.which"; // whose id that is: another one for each file and map that is opened

/** What a page begins with: what this tab had, or what another tab has drawn of the same map since. @returns {Kept} */
export function keptHere() {
  const here = keptIn(() => sessionStorage);
  const last = keptLast();
  if (here.map === null) return last;
  return last.map !== null && last.which === here.which ? last : here;
}

/** What was drawn last, in whatever tab. @returns {Kept} */
export function keptLast() {
  return keptIn(() => localStorage);
}

/** @param {string} which @param {GameMap} map */
export function keep(which, map) {
  keepIn(() => localStorage, which, map);
  keepHere(which, map);
}

/** What this tab shows, but did not draw. @param {string} which @param {GameMap} map */
export function keepHere(which, map) {
  keepIn(() => sessionStorage, which, map);
}

/** @param {() => Storage} storage @returns {Kept} */
function keptIn(storage) {
  try {
    return { which: storage().getItem(WHICH) ?? "", map: keptMap(storage().getItem(MAP)) };
  } catch {
    return { which: "", map: null }; // storage is forbidden
  }
}

/** @param {() => Storage} storage @param {string} which @param {GameMap} map */
function keepIn(storage, which, map) {
  try {
    storage().setItem(WHICH, which);
    storage().setItem(MAP, JSON.stringify(map));
  } catch {
    // nothing to keep it in
  }
}
