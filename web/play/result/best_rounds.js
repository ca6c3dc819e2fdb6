// @ts-check
/*
 * The best result per map that this browser remembers: same map, same items, same time limit. More delivered is better,
 * then less time. Kept in localStorage.
 */

import { lastingStorage } from "../../core/browser_storage.js";
import { textHash } from "../../core/text_hash.js";

/** @typedef {import("../game.js").RoundResult} RoundResult */
/** @typedef {import("./result.js").Round & {limit_ticks: number}} Round */
/** @typedef {{delivered: number, ticks: number}} Score */
/** @typedef {Score & {at: number, last: string, before: Score | null}} Kept `last`: the round that was counted last */

const KEY = "movingout.best";
const MOST = 300; // maps and variants; the oldest are forgotten

/**
 * Counts a finished round once, however often it is shown, and tells the best one before it.
 * @param {Round} round
 * @param {RoundResult} result
 * @param {Pick<Storage, "getItem" | "setItem">} [storage]
 * @returns {Score | null} null for a first round, or where nothing can be kept
 */
export function countRound(round, result, storage = lastingStorage()) {
  try {
    /** @type {Record<string, Kept>} */
    const all = keptBests(storage);
    const key = keyOf(round);
    const kept = all[key] ?? null;
    if (result.recording !== "" && kept?.last === result.recording) return kept.before;
    const before = kept && { delivered: kept.delivered, ticks: kept.ticks };
    const best = before && !isBetter(result, before) ? before : { delivered: result.delivered, ticks: result.ticks };
    all[key] = { ...best, at: Date.now(), last: result.recording, before };
    storage.setItem(KEY, JSON.stringify(newest(all)));
    return before;
  } catch {
    return null; // no storage
  }
}

/**
 * What is kept; a value of somebody else under our key counts as nothing, and is written over.
 * @param {Pick<Storage, "getItem">} storage
 * @returns {Record<string, Kept>}
 */
function keptBests(storage) {
  const text = storage.getItem(KEY) ?? "{}";
  try {
    const all = JSON.parse(text);
    const isOurs = all !== null && typeof all === "object" && !Array.isArray(all);
    return isOurs ? Object.fromEntries(Object.entries(all).filter(([, kept]) => Number.isFinite(kept?.ticks))) : {};
  } catch {
    return {};
  }
}

/** @param {Score} one @param {Score} other */
export function isBetter(one, other) {
  return one.delivered > other.delivered || (one.delivered === other.delivered && one.ticks < other.ticks);
}

/** @param {Record<string, Kept>} all */
function newest(all) {
  const entries = Object.entries(all).sort(([, one], [, other]) => other.at - one.at);
  return Object.fromEntries(entries.slice(0, MOST));
}

/** @param {Round} round */
function keyOf({ map, limit_ticks: limit }) {
  return `${map.name} ${limit} ${textHash(JSON.stringify([map.robots, map.walls, map.goals, map.items]))}`;
}
