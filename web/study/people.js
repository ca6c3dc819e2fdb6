// @ts-check
/*
 * The people at this screen, one or two, each with a place in the study, and whose turn it is. The tokens are kept in
 * localStorage, so that a reload or another tab returns to the same places.
 */

/** @typedef {import("./service.js").View} View */
/** @typedef {import("./service.js").Step} Step */

const KEYS = ["movingout-study-token", "movingout-study-token-2"];
const TOGETHER = ["input-check", "practice", "round", "waiting", "break", "paused"]; // done by both at once

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

/**
 * Whose screen is shown: the number of one person, or of both where they do the step together. A person with a step of
 * their own comes first, then the one who is behind; a person who has finished comes last.
 * @param {readonly View[]} views one per person
 * @returns {number[]}
 */
export function whoseTurn(views) {
  if (views.length < 2) return [0];
  const steps = views.map(({ step }) => step);
  const busy = steps.findIndex(({ kind }) => !TOGETHER.includes(kind) && kind !== "code");
  if (busy !== -1) return [busy];
  const playing = [0, 1].filter((person) => steps[person].kind !== "code");
  if (playing.length === 2 && steps[0].key === steps[1].key && steps[0].kind === steps[1].kind) return [0, 1];
  if (playing.length === 2) return [views[0].position.done <= views[1].position.done ? 0 : 1];
  return playing.length === 1 ? playing : [0];
}

/** @param {readonly View[]} views @returns {boolean} whether they may all be at the consent, also behind a pause */
export function areUndecided(views) {
  return views.every(({ step }) => step.kind === "consent" || step.kind === "paused");
}

/**
 * Who still sits here: everybody but who declined, of whom nothing is kept, so that somebody else may come instead. A
 * place with a completion code stays.
 * @param {readonly View[]} views one per person
 * @returns {number[]} empty where nobody does
 */
export function stillHere(views) {
  return views.flatMap(({ step }, person) => (step.kind === "code" && !step.code ? [] : [person]));
}

/**
 * The room of a round with one entry per seat: its token, or null where somebody else sits, and who of those who play
 * here sits there, or -1. Null until the seats of everybody here are known.
 * @param {readonly Step[]} steps of the people who play
 * @returns {{id: string, path: string, tokens: (string | null)[], people: number[]} | null}
 */
export function seatsToTake(steps) {
  const rooms = steps.map(({ room }) => room);
  const [first] = rooms;
  if (!first || rooms.some((room) => room?.id !== first.id)) return null;
  const tokens = [0, 1].map((seat) => rooms.find((room) => room?.seat === seat)?.token ?? null);
  const people = [0, 1].map((seat) => rooms.findIndex((room) => room?.seat === seat));
  return { id: first.id, path: first.path, tokens, people };
}
