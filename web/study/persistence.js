// @ts-check
/*
 * Asks again, ever later, until the server has answered: it may be starting again, or the network is away. Only what
 * may safely be asked twice goes through here. A refusal is an answer.
 */

import { ApiError } from "../core/api.js";

const WAITS_MS = [500, 1000, 2000, 4000];
const AWAY = [0, 502, 503, 504]; // nobody answers, or a proxy says so

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
