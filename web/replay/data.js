// @ts-check
/*
 * A finished episode as the replay shows it: the poses between ticks, and what was held and delivered after each tick.
 * Pure. Data: GET /api/recordings/{id} and …/poses (int16 x, y, angle per body, the wire's scales).
 */

import { POSE_MS } from "../core/ticks.js";
import { ANGLE_SCALE, POSES_PER_TICK, POSITION_SCALE, TICK_MS } from "../messages.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */
/** @typedef {import("../view/render.js").Triple} Triple */
/** @typedef {{tick: number, kind: string, seat: number, item: number, detail: string}} ReplayEvent */
/**
 * @typedef {object} Summary
 * @property {string} id
 * @property {GameMap} map
 * @property {string} started UTC, ISO 8601
 * @property {number} limit_ticks
 * @property {number} ticks
 * @property {string} outcome
 * @property {boolean} complete
 * @property {string} [damage]
 * @property {boolean} [exact] whether the poses were re-simulated bit for bit
 * @property {boolean} [has_thoughts] whether an agent named what it weighed
 * @property {{colour: string, kind: string, name: string, device?: string}[]} seats
 * @property {number[][]} held per state, from 0 to `ticks`: item of blue and red, -1 none
 * @property {boolean[]} [delivered_at_start] per item, whether it lies in a goal before the first tick
 * @property {boolean[][]} delivered per tick, from 1 to `ticks`
 * @property {ReplayEvent[]} events
 * @property {import("../core/metric_values.js").MetricValues} metrics
 * @property {import("../core/metric_values.js").MetricCurves} curves
 */

const VALUES_PER_BODY = 3;

export class ReplayError extends Error {}

export class Replay {
  /** @type {DataView} */
  #poses;
  #bodies;

  /**
   * @param {Summary} summary
   * @param {ArrayBuffer} poses (1 + 5 ticks) frames of (2 + items) bodies, little endian
   */
  constructor(summary, poses) {
    this.summary = summary;
    this.#bodies = 2 + summary.map.items.length;
    this.#poses = new DataView(poses);
    this.frames = poses.byteLength / (2 * VALUES_PER_BODY * this.#bodies);
    const expected = 1 + POSES_PER_TICK * summary.ticks;
    if (this.frames !== expected)
      throw new ReplayError(`This recording has ${this.frames} pictures where ${expected} belong.`);
  }

  get ticks() {
    return this.summary.ticks;
  }

  get durationMs() {
    return this.ticks * TICK_MS;
  }

  /**
   * The arena `timeMs` after the start, interpolated between poses.
   * @param {number} timeMs
   * @returns {View}
   */
  viewAt(timeMs) {
    const place = Math.min(Math.max(timeMs, 0), this.durationMs) / POSE_MS;
    const frame = Math.min(Math.floor(place), this.frames - 1);
    const next = Math.min(frame + 1, this.frames - 1);
    const tick = tickAt(timeMs);
    return {
      poses: Array.from({ length: this.#bodies }, (_, body) =>
        between(this.#pose(frame, body), this.#pose(next, body), place - frame),
      ),
      held: this.summary.held[Math.min(tick, this.ticks)] ?? [-1, -1],
      delivered: this.deliveredAfter(tick),
    };
  }

  /** @param {number} tick @returns {boolean[]} */
  deliveredAfter(tick) {
    const atStart = this.summary.delivered_at_start ?? []; // not of servers before 2026-11-28
    return this.summary.delivered[Math.min(tick, this.ticks) - 1] ?? atStart;
  }

  /** @param {number} frame @param {number} body @returns {Triple} */
  #pose(frame, body) {
    const start = 2 * VALUES_PER_BODY * (frame * this.#bodies + body);
    const value = (/** @type {number} */ index) => this.#poses.getInt16(start + 2 * index, true);
    return [value(0) / POSITION_SCALE, value(1) / POSITION_SCALE, value(2) / ANGLE_SCALE];
  }
}

/**
 * The id that the address of a replay names. One cut within a letter is taken as it stands: no recording has it.
 * @param {string} path
 */
export function episodeIn(path) {
  const name = path.split("/").at(-1) ?? "";
  try {
    return decodeURIComponent(name);
  } catch {
    return name;
  }
}

/** The tick whose state stands at `timeMs`: 0 before the first. @param {number} timeMs */
export function tickAt(timeMs) {
  return Math.floor(timeMs / TICK_MS + 1e-6);
}

/**
 * Linear for positions, the shorter way round for angles.
 * @param {Triple} a
 * @param {Triple} b
 * @param {number} part 0 to 1
 * @returns {Triple}
 */
function between(a, b, part) {
  const turn = 2 * Math.PI;
  const angle = ((((b[2] - a[2] + Math.PI) % turn) + turn) % turn) - Math.PI;
  return [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * angle];
}

/**
 * The tick of a deep link `#tick=123`; null when there is none.
 * @param {string} hash
 * @param {number} ticks
 */
export function linkedTick(hash, ticks) {
  const match = /^#tick=(\d{1,9})$/.exec(hash);
  return match ? Math.min(Number(match[1]), ticks) : null;
}
