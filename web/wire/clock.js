// The server's clock, estimated from pings. Knows no socket; time comes in as an argument. All times in ms.

const SAMPLES = 16; // the offset is taken from the fastest of the last 16 round trips
const SLEW = 0.05; // the estimate never runs more than 5 % faster or slower than real time

/** @typedef {{offsetMs: number, rttMs: number}} Sample */

export class ServerClock {
  /** @type {Sample[]} */
  #samples = [];
  #offsetMs = 0;
  #slewedAtMs = 0;

  /** Starts over: another connection, perhaps another server. */
  reset() {
    this.#samples = [];
  }

  /** Whether `now` is meaningful yet. */
  get known() {
    return this.#samples.length > 0;
  }

  /** Round trip of the newest ping, -1 before the first. */
  get rttMs() {
    return this.#samples.at(-1)?.rttMs ?? -1;
  }

  /**
   * One ping: sent at local `sentMs`, stamped `serverMs` by the server, back at local `receivedMs`.
   * @param {number} sentMs @param {number} serverMs @param {number} receivedMs
   */
  add(sentMs, serverMs, receivedMs) {
    const rttMs = receivedMs - sentMs;
    if (!(rttMs >= 0)) return; // not one of ours
    const first = !this.known;
    this.#samples.push({ offsetMs: serverMs - sentMs - rttMs / 2, rttMs });
    if (this.#samples.length > SAMPLES) this.#samples.shift();
    if (first) {
      this.#offsetMs = this.#targetMs();
      this.#slewedAtMs = receivedMs;
    } else {
      this.#slew(receivedMs);
    }
  }

  /** The server's time at local time `localMs`. @param {number} localMs */
  now(localMs) {
    this.#slew(localMs);
    return localMs + this.#offsetMs;
  }

  #targetMs() {
    return this.#samples.reduce((best, sample) => (sample.rttMs < best.rttMs ? sample : best)).offsetMs;
  }

  /** @param {number} localMs */
  #slew(localMs) {
    if (!this.known) return;
    const reach = SLEW * Math.max(0, localMs - this.#slewedAtMs);
    const error = this.#targetMs() - this.#offsetMs;
    this.#offsetMs += Math.max(-reach, Math.min(reach, error));
    this.#slewedAtMs = Math.max(this.#slewedAtMs, localMs);
  }
}
