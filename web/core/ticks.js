// @ts-check
/*
 * Ticks in the units that people and pages use. The clock itself is declared by the server: web/messages.js.
 */

import { POSES_PER_TICK, TICK_MS } from "../messages.js";

export const TICKS_PER_S = 1000 / TICK_MS;
export const POSE_MS = TICK_MS / POSES_PER_TICK;

/** @param {number} seconds @returns {number} ticks */
export function ticksOf(seconds) {
  return seconds * TICKS_PER_S;
}

/** @param {number} ticks @returns {number} seconds */
export function secondsOf(ticks) {
  return ticks / TICKS_PER_S;
}

/** Minutes and seconds, a second begun is counted whole: 30.1 -> "0:31". @param {number} seconds */
export function clockText(seconds) {
  const whole = Math.max(0, Math.ceil(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
