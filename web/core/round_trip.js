// @ts-check
/*
 * From which round trips a link is no longer good, then bad: one link has one colour, for who plays and who watches.
 */

const FAIR_MS = 80;
const POOR_MS = 200;

/** @param {number} rttMs known, not -1 @returns {"ok" | "attention" | "bad"} */
export function roundTripTone(rttMs) {
  return rttMs < FAIR_MS ? "ok" : rttMs < POOR_MS ? "attention" : "bad";
}
