// @ts-check
/*
 * Whose turn it is at this screen, and which seats its people take: told from the newest view of each of them.
 */

/** @typedef {import("./service.js").View} View */
/** @typedef {import("./service.js").Step} Step */

const TOGETHER = ["input-check", "practice", "round", "waiting", "break", "paused"]; // done by both at once

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
