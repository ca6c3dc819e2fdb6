// @ts-check
/*
 * How long a page of questions has been shown, and for how much of that time the tab was hidden.
 */

export class PageTimer {
  #start = performance.now();
  #hidden = 0;
  #hiddenSince = NaN;
  #listen = () => this.#visibility();

  constructor() {
    document.addEventListener("visibilitychange", this.#listen);
    this.#visibility();
  }

  restart() {
    this.#start = performance.now();
    this.#hidden = 0;
    if (document.hidden) this.#hiddenSince = this.#start;
  }

  stop() {
    document.removeEventListener("visibilitychange", this.#listen);
  }

  /** Milliseconds since the last restart. @returns {{elapsed_ms: number, hidden_ms: number}} */
  read() {
    const now = performance.now();
    const running = document.hidden ? now - this.#hiddenSince : 0;
    return { elapsed_ms: Math.round(now - this.#start), hidden_ms: Math.round(this.#hidden + running) };
  }

  #visibility() {
    const now = performance.now();
    if (document.hidden) this.#hiddenSince = now;
    else if (!Number.isNaN(this.#hiddenSince)) {
      this.#hidden += now - this.#hiddenSince;
      this.#hiddenSince = NaN;
    }
  }
}
