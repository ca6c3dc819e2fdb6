// @ts-check
/*
 * Saves answers one at a time and tries again until each has arrived; of several for one question only the newest
 * is sent. Knows neither page nor questions: `send` does the request, `later` the waiting (tests pass their own).
 */

/** @typedef {{question: string, value: number, text: string, elapsed_ms: number, hidden_ms?: number}} Answer */
/**
 * @typedef {object} SaveState
 * @property {number} waiting  answers that have not arrived
 * @property {unknown} failure  why the last try failed that will be repeated, else null
 * @property {unknown} refused  why the server did not take the last answer, else null
 */

const RETRY_MS = [1000, 2000, 4000, 8000];

export class AnswerQueue {
  /** @type {Map<string, Answer>} */
  #waiting = new Map();
  /** @type {Promise<void> | null} */
  #sending = null;
  #failures = 0;
  /** @type {unknown} */
  #failure = null;
  /** @type {unknown} */
  #refused = null;
  /** @type {() => void} ends a wait early */
  #wake = () => {};

  /**
   * @param {(answer: Answer) => Promise<void>} send rejects with an error whose `status` is 0 or 5xx where a second
   *   try can help
   * @param {(state: SaveState) => void} onState
   * @param {(ms: number) => Promise<void>} [later]
   */
  constructor(send, onState, later = (ms) => new Promise((done) => setTimeout(done, ms))) {
    this.send = send;
    this.onState = onState;
    this.later = later;
  }

  /** @param {Answer} answer */
  add(answer) {
    this.#refused = null;
    this.#waiting.set(answer.question, answer);
    this.#tell();
    this.#sending ??= this.#run().finally(() => (this.#sending = null));
  }

  /** Retries at once: the connection is back. */
  retryNow() {
    this.#wake();
  }

  /** Resolves when nothing is waiting. */
  async settled() {
    while (this.#sending) await this.#sending;
  }

  /** @returns {SaveState} */
  get state() {
    return { waiting: this.#waiting.size, failure: this.#failure, refused: this.#refused };
  }

  async #run() {
    for (let next = this.#first(); next; next = this.#first()) {
      try {
        await this.send(next);
        this.#arrived();
        this.#forget(next);
      } catch (error) {
        if (!canRetry(error)) {
          this.#refused = error;
          this.#forget(next);
        } else {
          this.#failure = error;
          await this.#pause();
        }
      }
      this.#tell();
    }
  }

  #arrived() {
    this.#failures = 0;
    this.#failure = null;
  }

  #first() {
    return this.#waiting.values().next().value;
  }

  /** A newer answer to the same question stays. @param {Answer} answer */
  #forget(answer) {
    if (this.#waiting.get(answer.question) === answer) this.#waiting.delete(answer.question);
  }

  async #pause() {
    const wait = RETRY_MS[Math.min(this.#failures, RETRY_MS.length - 1)];
    this.#failures += 1;
    this.#tell();
    await Promise.race([this.later(wait), new Promise((done) => (this.#wake = () => done(undefined)))]);
  }

  #tell() {
    this.onState(this.state);
  }
}

/** @param {unknown} error */
function canRetry(error) {
  const status = error instanceof Error && "status" in error ? Number(error.status) : -1;
  return status === 0 || status === 408 || status === 429 || status >= 500;
}
