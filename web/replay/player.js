// @ts-check
/*
 * The position in a replay and how it moves: play, pause, speed, step, seek. Pure: time comes in as an argument.
 */

export const SPEEDS = /** @type {const} */ ([0.25, 0.5, 1, 2, 4, 8]);

export class Player {
  /** @param {number} durationMs @param {number} stepMs one tick */
  constructor(durationMs, stepMs) {
    this.durationMs = durationMs;
    this.stepMs = stepMs;
    this.timeMs = 0;
    this.speed = 1;
    this.playing = false;
  }

  /** Lets `elapsedMs` of real time pass; stops at the end. @param {number} elapsedMs */
  advance(elapsedMs) {
    if (!this.playing) return;
    this.timeMs = Math.min(this.timeMs + elapsedMs * this.speed, this.durationMs);
    if (this.timeMs >= this.durationMs) this.playing = false;
  }

  /** Plays or pauses; at the end it starts from the beginning. */
  toggle() {
    if (!this.playing && this.timeMs >= this.durationMs) this.timeMs = 0;
    this.playing = !this.playing && this.durationMs > 0;
  }

  /** @param {number} timeMs */
  seek(timeMs) {
    this.timeMs = Math.min(Math.max(timeMs, 0), this.durationMs);
  }

  /**
   * Pauses and moves by whole ticks; between two ticks, the first step goes to the adjacent one.
   * @param {number} steps
   */
  step(steps) {
    this.playing = false;
    const place = this.timeMs / this.stepMs;
    const from = steps > 0 ? Math.floor(place + 1e-6) : Math.ceil(place - 1e-6);
    this.seek((from + steps) * this.stepMs);
  }

  /** The next slower or faster of `SPEEDS`. @param {-1 | 1} direction */
  changeSpeed(direction) {
    const index = SPEEDS.findIndex((speed) => speed === this.speed) + direction;
    this.speed = SPEEDS[Math.min(Math.max(index, 0), SPEEDS.length - 1)];
  }
}

/**
 * The tick of the next event in one direction; the end of the episode where there is none.
 * @param {readonly {tick: number}[]} events in order of ticks
 * @param {number} tick
 * @param {-1 | 1} direction
 * @param {number} ticks
 */
export function nextEventTick(events, tick, direction, ticks) {
  const candidates = events.map((event) => event.tick).filter((other) => (direction > 0 ? other > tick : other < tick));
  if (candidates.length === 0) return direction > 0 ? ticks : 0;
  return direction > 0 ? Math.min(...candidates) : Math.max(...candidates);
}
