// @ts-check
/*
 * How long ago something was. While the machine sleeps, performance.now stands still in some browsers (macOS, Linux);
 * Date.now goes on, and jumps where somebody sets the clock. The longer time of both counts: asking the server too
 * early costs nothing.
 */

export class Elapsed {
  #atMs = 0;
  #wallMs = 0;

  /** @param {() => number} now @param {() => number} wall both in ms */
  constructor(now = () => performance.now(), wall = () => Date.now()) {
    this.now = now;
    this.wall = wall;
    this.restart();
  }

  /** It is now. */
  restart() {
    this.#atMs = this.now();
    this.#wallMs = this.wall();
  }

  /** In ms; a sleep counts. */
  get ms() {
    return Math.max(this.now() - this.#atMs, this.wall() - this.#wallMs);
  }
}
