// @ts-check
/*
 * Repeats a request, with growing pauses, until the server answers: it may be restarting, or the network may be down.
 * Only for requests that are safe to repeat. A refusal is an answer, unless it is one for the moment.
 */

import { ApiError } from "../core/api.js";

const WAITS_MS = [500, 1000, 2000, 4000];
const AWAY = [0, 408, 502, 503, 504]; // no answer, or a proxy that got none, or not the whole request in time
const BUSY = [429, 507]; // too many requests at once, or a disk or database that takes nothing for now

export class Persistence {
  /**
   * @param {(problem: ApiError | null) => void} onState why it is asked again, null when it is not
   * @param {(ms: number) => Promise<void>} [later]
   */
  constructor(onState, later = soonOrOnline) {
    this.onState = onState;
    this.later = later;
  }

  /** @template T @param {() => Promise<T>} ask @returns {Promise<T>} */
  async until(ask) {
    for (let tries = 0; ; tries += 1) {
      try {
        const answer = await ask();
        this.onState(null);
        return answer;
      } catch (error) {
        if (!(error instanceof ApiError) || !passes(error)) {
          this.onState(null);
          throw error;
        }
        this.onState(error);
        await this.later(WAITS_MS[Math.min(tries, WAITS_MS.length - 1)]);
      }
    }
  }
}

/** @param {ApiError} error */
function passes({ status, code }) {
  return AWAY.includes(status) || isBusy({ status, code });
}

/**
 * Whether the server is there and cannot take the request for now. Whoever is locked out for wrong codes is told at
 * once: asking again would be another guess.
 * @param {{status: number, code: string}} error
 */
export function isBusy({ status, code }) {
  return BUSY.includes(status) && code !== "locked";
}

/** @param {number} ms */
function soonOrOnline(ms) {
  return /** @type {Promise<void>} */ (
    new Promise((done) => {
      setTimeout(done, ms);
      window.addEventListener("online", () => done(undefined), { once: true });
    })
  );
}
