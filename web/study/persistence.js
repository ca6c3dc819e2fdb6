// @ts-check
/*
 * Repeats a request, with growing pauses, until the server answers: it may be restarting, or the network may be down.
 * Only for requests that are safe to repeat. A refusal is an answer.
 */

import { ApiError } from "../core/api.js";

const WAITS_MS = [500, 1000, 2000, 4000];
const AWAY = [0, 408, 502, 503, 504]; // no answer, or a proxy that got none, or not the whole request in time

export class Persistence {
  /**
   * @param {(offline: boolean) => void} onState
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
        this.onState(false);
        return answer;
      } catch (error) {
        if (!(error instanceof ApiError) || !AWAY.includes(error.status)) {
          this.onState(false);
          throw error;
        }
        this.onState(true);
        await this.later(WAITS_MS[Math.min(tries, WAITS_MS.length - 1)]);
      }
    }
  }
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
