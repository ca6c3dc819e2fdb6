// Poses on the server's time line, and the playhead that moves along it. Pure: time comes in as an argument.
// The server sends the real poses of the coming tick in one bundle; the playhead follows some milliseconds behind the
// arrival, so that what is drawn at display rate always lies between two known poses.

import { POSE_MS } from "../core/ticks.js";
import { EVENT } from "../messages.js";

/** @typedef {import("../messages.js").Bundle} Bundle */
/** @typedef {import("../messages.js").FullState} FullState */
/** @typedef {import("./render.js").Triple} Triple */
/** @typedef {import("../messages.js").BundleEvent & {tick: number, timeMs: number}} TimedEvent */
/**
 * What is known at one instant of the time line.
 * @typedef {object} Frame
 * @property {number} timeMs  server time
 * @property {number} tick  the tick that this instant belongs to
 * @property {readonly Triple[]} poses
 * @property {readonly number[]} held
 * @property {readonly boolean[]} delivered
 */

const KEEP_MS = 2000; // how much of the past is kept
const MISSED_MS = 500; // an event so long ago is not shown or heard any more
export const EXTRAPOLATE_MS = 60; // without data: extrapolate this long, then freeze

/** The poses of one round in order of time. */
export class Timeline {
  /** @type {Frame[]} */
  #frames = [];
  /** @type {TimedEvent[]} */
  #events = [];
  #newestTick = 0;

  clear() {
    this.#frames = [];
    this.#events = [];
    this.#newestTick = 0;
  }

  /** Number of the newest tick received. */
  get newestTick() {
    return this.#newestTick;
  }

  /** Server time of the newest pose; -Infinity before the first. */
  get endMs() {
    return this.#frames.at(-1)?.timeMs ?? -Infinity;
  }

  /** Starts from a whole state, unless bundles have already told more. @param {FullState} state */
  reset(state) {
    if (this.#frames.length > 0 && state.tick <= this.#newestTick) return;
    this.clear();
    this.#newestTick = state.tick;
    const poses = state.poses.map(([x, y, angle]) => /** @type {Triple} */ ([x, y, angle]));
    this.#frames.push({ timeMs: state.time_ms, tick: state.tick, poses, held: state.held, delivered: state.delivered });
  }

  /** Adds one tick. @param {Bundle} bundle */
  push(bundle) {
    if (this.#frames.length > 0 && bundle.tick <= this.#newestTick) return;
    this.#newestTick = bundle.tick;
    this.#holdUntil(bundle.timeMs);
    const before = this.#frames.at(-1);
    for (let index = 0; index < bundle.poseCount; index += 1) {
      this.#frames.push({
        timeMs: bundle.timeMs + POSE_MS * (index + 1),
        tick: bundle.tick,
        poses: posesOf(bundle, index),
        held: heldAt(bundle, index, before?.held),
        delivered: deliveredAt(bundle, index, before?.delivered),
      });
    }
    for (const event of bundle.events) {
      this.#events.push({ ...event, tick: bundle.tick, timeMs: bundle.timeMs + POSE_MS * (event.pose + 1) });
    }
    this.#forget(bundle.timeMs - KEEP_MS);
  }

  /** After a pause or a skipped tick everything has stood still until `timeMs`. @param {number} timeMs */
  #holdUntil(timeMs) {
    const last = this.#frames.at(-1);
    if (last !== undefined && last.timeMs < timeMs - 1) this.#frames.push({ ...last, timeMs });
  }

  /** @param {number} timeMs */
  #forget(timeMs) {
    const keepFrom = this.#frames.findIndex((frame) => frame.timeMs >= timeMs);
    if (keepFrom > 1) this.#frames.splice(0, keepFrom - 1);
  }

  /**
   * The events up to `timeMs` that were not taken yet, oldest first; what a hidden tab missed is left out.
   * @param {number} timeMs @returns {TimedEvent[]}
   */
  takeEvents(timeMs) {
    const later = this.#events.findIndex((event) => event.timeMs > timeMs);
    const taken = this.#events.splice(0, later === -1 ? this.#events.length : later);
    return taken.filter((event) => event.timeMs >= timeMs - MISSED_MS);
  }

  /**
   * The instant `timeMs`: interpolated between poses, extrapolated for at most 60 ms after the last.
   * @param {number} timeMs @returns {Frame | null} null before anything is known
   */
  at(timeMs) {
    const next = this.#frames.findIndex((frame) => frame.timeMs > timeMs);
    if (next === 0) return this.#frames[0];
    if (next === -1) return this.#beyond(timeMs);
    const [from, to] = [this.#frames[next - 1], this.#frames[next]];
    const share = (timeMs - from.timeMs) / (to.timeMs - from.timeMs);
    return { ...from, timeMs, poses: from.poses.map((pose, body) => between(pose, to.poses[body], share)) };
  }

  /** @param {number} timeMs @returns {Frame | null} */
  #beyond(timeMs) {
    const [before, last] = this.#frames.slice(-2);
    if (last === undefined || last.timeMs - before.timeMs > 2 * POSE_MS) return last ?? before ?? null;
    const ahead = Math.min(timeMs - last.timeMs, EXTRAPOLATE_MS) / (last.timeMs - before.timeMs);
    return { ...last, poses: last.poses.map((pose, body) => between(before.poses[body], pose, 1 + ahead)) };
  }
}

/** @param {Bundle} bundle @param {number} index @returns {Triple[]} */
function posesOf(bundle, index) {
  return Array.from({ length: bundle.bodies }, (_, body) => {
    const at = 3 * (index * bundle.bodies + body);
    return [bundle.poses[at], bundle.poses[at + 1], bundle.poses[at + 2]];
  });
}

/**
 * A grip changes at the pose that its event names, not at the tick's end.
 * @param {Bundle} bundle
 * @param {number} index
 * @param {readonly number[] | undefined} before
 */
function heldAt(bundle, index, before) {
  if (before === undefined) return bundle.held;
  return bundle.held.map((now, seat) => {
    const change = bundle.events.find(
      (event) => event.seat === seat && (event.code === EVENT.grab || event.code === EVENT.release),
    );
    return change !== undefined && index < change.pose ? before[seat] : now;
  });
}

/** @param {Bundle} bundle @param {number} index @param {readonly boolean[] | undefined} before */
function deliveredAt(bundle, index, before) {
  if (before === undefined) return bundle.delivered;
  return bundle.delivered.map((now, item) => {
    const change = bundle.events.find(
      (event) => event.item === item && (event.code === EVENT.delivered || event.code === EVENT.undelivered),
    );
    return change !== undefined && index < change.pose ? before[item] : now;
  });
}

/**
 * Linear, the angle by the shorter way round; share may exceed 1.
 * @param {Triple} from
 * @param {Triple} to
 * @param {number} share
 * @returns {Triple}
 */
export function between(from, to, share) {
  const turn = to[2] - from[2];
  const shorter = turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI));
  return [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1]), from[2] + share * shorter];
}

const WINDOW_MS = 10_000; // window over which arrival times are judged
const MARGIN_MIN_MS = 8;
const MARGIN_MAX_MS = 60;
const JUMP_MS = 250; // beyond this the head jumps instead of catching up
const CATCH_UP_MS = 50; // this far behind, time runs at 1.1

/** The moving "now" of what is drawn, a little behind the newest bundle. */
export class PlayHead {
  /** @type {{atMs: number, delayMs: number}[]} */
  #arrivals = [];
  #timeMs = NaN;
  #movedAtMs = 0;

  reset() {
    this.#arrivals = [];
    this.#timeMs = NaN;
  }

  /** How far behind the server's clock the head should be: the usual delay plus a margin for late bundles. */
  get delayMs() {
    if (this.#arrivals.length === 0) return MARGIN_MIN_MS;
    const delays = this.#arrivals.map((arrival) => arrival.delayMs).sort((a, b) => a - b);
    const late = delays[Math.min(delays.length - 1, Math.ceil(0.99 * delays.length) - 1)];
    return delays[0] + Math.max(MARGIN_MIN_MS, Math.min(MARGIN_MAX_MS, late - delays[0]));
  }

  /**
   * A bundle of the tick that began at `tickMs` arrived at `serverMs`, both by the server's clock.
   * @param {number} tickMs
   * @param {number} serverMs
   */
  arrived(tickMs, serverMs) {
    this.#arrivals.push({ atMs: serverMs, delayMs: serverMs - tickMs });
    while (this.#arrivals[0].atMs < serverMs - WINDOW_MS) this.#arrivals.shift();
  }

  /**
   * Advances to the server's time `serverMs`; never more than 60 ms past `endMs`, the newest pose.
   * @param {number} serverMs @param {number} endMs @returns {number} server time to draw
   */
  advance(serverMs, endMs) {
    const target = serverMs - this.delayMs;
    const error = target - this.#timeMs;
    const elapsed = Math.max(0, serverMs - this.#movedAtMs);
    this.#movedAtMs = serverMs;
    const behind = error - elapsed;
    if (!(Math.abs(behind) <= JUMP_MS)) this.#timeMs = target;
    else this.#timeMs += elapsed * rateFor(behind);
    if (endMs > -Infinity) this.#timeMs = Math.min(this.#timeMs, endMs + EXTRAPOLATE_MS);
    return this.#timeMs;
  }
}

/** How fast to play when the head is `behindMs` behind where it wants to be. @param {number} behindMs */
function rateFor(behindMs) {
  if (behindMs > CATCH_UP_MS) return 1.1;
  return 1 + Math.max(-0.05, Math.min(0.05, behindMs / 400));
}
