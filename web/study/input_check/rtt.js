// @ts-check
/*
 * The round trip time of a request in milliseconds: the median of several, one after the other.
 */

import { request } from "../../core/api.js";

const WARM_UP = 2; // the first ones open the connection
const SAMPLES = 9;

/** @param {() => Promise<unknown>} [ask] @param {() => number} [now] */
export async function measureRtt(ask = () => request("/healthz"), now = () => performance.now()) {
  const times = [];
  for (let index = 0; index < WARM_UP + SAMPLES; index += 1) {
    const start = now();
    await ask();
    if (index >= WARM_UP) times.push(now() - start);
  }
  return median(times);
}

/** @param {readonly number[]} values at least one */
export function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length / 2;
  return sorted.length % 2 === 1 ? sorted[Math.floor(middle)] : (sorted[middle - 1] + sorted[middle]) / 2;
}
