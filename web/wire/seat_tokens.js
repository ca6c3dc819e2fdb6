// The seat tokens of this tab, per room: they bring a reloaded page back to its seats. They change at each join.
// A page that goes away leaves them to the next tab, so that who closed the tab and opens the link again sits where
// they sat; only the last room is kept, and a page that is there keeps its own.

const LEFT = "movingout.left";

/** What could not be stored, by room: this page still comes back after a loss. @type {Map<string, string[]>} */
const ofThisPage = new Map();

/** @param {string} room */
const keyOf = (room) => `movingout.tokens.${room}`;

/** @param {string} room @returns {string[]} in seat order; empty when this tab has no seat there */
export function loadTokens(room) {
  try {
    return ofThisPage.get(room) ?? textsIn(JSON.parse(sessionStorage.getItem(keyOf(room)) ?? "[]"));
  } catch {
    return []; // storage switched off, or somebody else's value under our key
  }
}

/** @param {string} room @param {readonly (string | null)[]} tokens  null for a seat that is not ours */
export function saveTokens(room, tokens) {
  const own = tokens.filter((token) => token !== null);
  try {
    sessionStorage.setItem(keyOf(room), JSON.stringify(own));
    ofThisPage.delete(room);
  } catch {
    ofThisPage.set(room, own); // forbidden or full: only a reload takes a new seat
  }
}

/** This page goes away: its seats are for the tab that comes next. @param {string} room */
export function leaveTokens(room) {
  try {
    const tokens = loadTokens(room);
    if (tokens.length > 0) localStorage.setItem(LEFT, JSON.stringify({ room, tokens }));
  } catch {
    // Without storage a new tab takes a new seat.
  }
}

/** A tab without a seat in this room takes those that a closed one has left. @param {string} room */
export function takeLeftTokens(room) {
  try {
    const left = JSON.parse(localStorage.getItem(LEFT) ?? "null");
    if (left?.room !== room) return;
    localStorage.removeItem(LEFT);
    if (loadTokens(room).length === 0) saveTokens(room, textsIn(left.tokens));
  } catch {
    // As above.
  }
}

/** @param {unknown} value @returns {string[]} */
function textsIn(value) {
  return Array.isArray(value) ? value.filter((text) => typeof text === "string") : [];
}
