// The seat tokens of this tab, per room: they bring a reloaded page back to its seats. They change at each join.

/** @param {string} room */
const keyOf = (room) => `movingout.tokens.${room}`;

/** @param {string} room @returns {string[]} in seat order; empty when this tab has no seat there */
export function loadTokens(room) {
  try {
    const tokens = JSON.parse(sessionStorage.getItem(keyOf(room)) ?? "[]");
    return Array.isArray(tokens) ? tokens.filter((token) => typeof token === "string") : [];
  } catch {
    return []; // storage switched off, or somebody else's value under our key
  }
}

/** @param {string} room @param {readonly (string | null)[]} tokens  null for a seat that is not ours */
export function saveTokens(room, tokens) {
  try {
    const own = tokens.filter((token) => token !== null);
    sessionStorage.setItem(keyOf(room), JSON.stringify(own));
  } catch {
    // Without storage a reload takes a new seat; the game itself goes on.
  }
}
