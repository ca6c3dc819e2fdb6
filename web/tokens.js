// @ts-check
/*
 * The seat tokens of a room, kept for this tab: sessionStorage key `movingout.tokens.<room>`, a JSON list of
 * strings. The lobby writes what POST /api/rooms returned; the play page sends them in `Join` and writes the new
 * ones of `Welcome`. A tab that is closed gives its seats up; a reload keeps them.
 */

/** @param {string} room */
export function tokensKey(room) {
  return `movingout.tokens.${room}`;
}

/**
 * @param {string} room
 * @param {Storage} [storage]
 * @returns {string[]}
 */
export function readTokens(room, storage = sessionStorage) {
  try {
    const tokens = JSON.parse(storage.getItem(tokensKey(room)) ?? "[]");
    return Array.isArray(tokens) ? tokens.filter((token) => typeof token === "string") : [];
  } catch {
    return []; // storage is forbidden, or somebody else wrote there
  }
}

/**
 * @param {string} room
 * @param {readonly string[]} tokens
 * @param {Storage} [storage]
 */
export function keepTokens(room, tokens, storage = sessionStorage) {
  storage.setItem(tokensKey(room), JSON.stringify(tokens));
}
