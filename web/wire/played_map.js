// @ts-check
/*
 * The map that was just played, for the game after it. The server keeps no drawn map: the page sends it along, and on
 * the way to another page it lies in the storage of the tab.
 */

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {{shipped: readonly GameMap[], own: readonly GameMap[]}} Offered own: of the operator's folder */

const MEMORY = "movingout.played";
const DRAWN = "movingout.drawn"; // the room in which the editor's map was last played

/** @param {GameMap} map */
export function keepPlayed(map) {
  try {
    sessionStorage.setItem(MEMORY, JSON.stringify(map));
  } catch {
    // the next page offers the maps that the server has
  }
}

/** The map of this name, if it was the last one kept here. @param {string} name @returns {GameMap | null} */
export function keptPlayed(name) {
  try {
    const map = JSON.parse(sessionStorage.getItem(MEMORY) ?? "null");
    return map?.name === name && Array.isArray(map.items) ? map : null;
  } catch {
    return null; // storage is forbidden, or not ours
  }
}

/** The editor in this tab begins a game. @param {string} room */
export function keepDrawnIn(room) {
  try {
    sessionStorage.setItem(DRAWN, room);
  } catch {
    // the way back is the browser's
  }
}

/** Whether the editor in this tab began the game. @param {string} room */
export function isDrawnIn(room) {
  try {
    return sessionStorage.getItem(DRAWN) === room;
  } catch {
    return false; // storage is forbidden
  }
}

/** The number that shuffled the items of a map; null for a map as designed. @param {{variant?: string}} map */
export function seedOf({ variant = "" }) {
  const [, digits] = variant.match(/^challenge2-train-(\d+)$/) ?? [];
  return digits === undefined ? null : Number(digits);
}

/**
 * Whether the map played is among those offered: one of the operator's may be another drawing of its name. Shuffled
 * items are of the map with its walls and goals. A shipped name is nobody else's: the server takes no drawing of it,
 * though a recording may have an earlier one.
 * @param {GameMap} played @param {Offered} offered
 */
export function isOffered(played, { shipped, own }) {
  const drawing = (/** @type {GameMap} */ { walls, goals, robots, items }) =>
    JSON.stringify(played.variant ? [walls, goals] : [walls, goals, robots, items]);
  const isShipped = shipped.some(({ name }) => name === played.name);
  return isShipped || own.some((map) => map.name === played.name && drawing(map) === drawing(played));
}

/**
 * The map to play, for the request that opens a room. A drawn one is sent along, with its items as they are: the server
 * does not keep it. Varied and generated ones, "HandOff:mirror", have a name; shuffled ones have that of the designed
 * map, and a number.
 * @param {GameMap} played @param {string} name the map to play now, with shuffled items where `played` has them
 * @param {Offered} offered
 */
export function wantedMap(played, name, offered) {
  const drawn = name === played.name && !name.includes(":") && !isOffered(played, offered);
  return drawn ? { maps: [], map: played } : { maps: [name], challenge2_seed: seedOf(played) };
}
