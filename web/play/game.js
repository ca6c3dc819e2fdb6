// The state of the room as received, and the instant to show. Messages go in with their time of arrival; `show` returns
// what to draw now. No access to page, canvas or socket.

import { decodeValues } from "../core/metric_values.js";
import { ServerClock } from "../wire/clock.js";
import { EXTRAPOLATE_MS, PlayHead, Timeline } from "../view/interpolate.js";
import { FLAG_NOT_RECORDING } from "../messages.js";
import { startView } from "../view/render.js";

/** @typedef {import("../messages.js").ServerMessage} ServerMessage */
/** @typedef {import("../messages.js").Bundle} Bundle */
/** @typedef {import("../view/interpolate.js").TimedEvent} TimedEvent */
/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */
/** @typedef {import("../messages.js").Round & {map: GameMap}} Round */
/** @typedef {import("../core/metric_values.js").MetricValues} MetricValues */
/** @typedef {Omit<import("../messages.js").Result, "metrics"> & {metrics: MetricValues}} RoundResult */
/**
 * @typedef {object} Scene  one instant to show
 * @property {View} view
 * @property {number} tick  the newest tick whose end was shown
 * @property {boolean} stalled  the round is running but nothing arrives: the picture stands still
 * @property {TimedEvent[]} events  those since the previous scene
 */

const HOLD_MS = 400; // longest wait of a message that is ahead of the picture

export class Game {
  clock = new ServerClock();
  /** @type {import("../messages.js").Welcome | null} */
  welcome = null;
  /** @type {Round | null} */
  round = null;
  /** @type {import("../messages.js").RoomState | null} */
  room = null;
  /** @type {import("../messages.js").Tutorial | null} */
  tutorial = null;
  /** @type {RoundResult | null} */
  result = null;
  recording = true;
  #timeline = new Timeline();
  #head = new PlayHead();
  #timeMs = -Infinity;
  /** @type {{message: ServerMessage, atMs: number}[]} messages that the play head has not reached */
  #held = [];
  #rejoined = false;

  /** The seats of this page. */
  get own() {
    return this.welcome?.seats.map((grant) => grant.seat) ?? [];
  }

  /** What proves that a seat is this page's: another one after each new connection. @param {number} seat */
  tokenOf(seat) {
    return this.welcome?.seats.find((grant) => grant.seat === seat)?.token ?? "";
  }

  get phase() {
    return this.room?.phase ?? "lobby";
  }

  /** Whether everything was over before a round ended: somebody left, or it could not start. */
  get overBeforeRound() {
    return this.phase === "series_over" && this.result === null;
  }

  get newestTick() {
    return this.#timeline.newestTick;
  }

  /** How far the picture is behind the server's clock. */
  get delayMs() {
    return this.#head.delayMs;
  }

  /** @param {ServerMessage} message @param {number} atMs  local time */
  receive(message, atMs) {
    if (this.#held.length > 0 || this.#overtakes(message)) this.#held.push({ message, atMs });
    else this.#apply(message);
  }

  /** The end of a round arrives up to 100 ms before it is shown. @param {ServerMessage} message */
  #overtakes(message) {
    const ends = message.type === "result" || (message.type === "room" && message.phase.endsWith("_over"));
    return ends && this.phase === "playing" && this.#timeMs < this.#timeline.endMs;
  }

  /** @param {ServerMessage} message */
  #apply(message) {
    if (message.type === "welcome") {
      this.welcome = message;
      this.clock.reset(); // perhaps another server, with another clock and another newest tick
      this.#head.reset();
      this.#rejoined = true;
    }
    if (message.type === "round") this.#begin(/** @type {Round} */ (message));
    if (message.type === "tutorial") this.tutorial = message;
    if (message.type === "room") {
      this.room = message;
      this.recording = message.recording;
    }
    if (message.type === "keyframe" && message.epoch === this.round?.epoch) {
      if (this.#rejoined) this.#timeline.clear();
      this.#rejoined = false;
      this.#timeline.reset(message);
    }
    // A result from before a restart may have the paper's metrics alone, as fields of the message.
    if (message.type === "result")
      this.result = { ...message, metrics: decodeValues({ ...message, ...message.metrics }) };
  }

  /** @param {Round} round */
  #begin(round) {
    const same = round.epoch === this.round?.epoch && round.map.name === this.round.map.name;
    this.round = same && this.round !== null ? { ...round, map: this.round.map } : round; // drawings are cached by map
    if (same) return;
    this.result = null;
    this.tutorial = null;
    this.#timeline.clear();
    this.#timeMs = -Infinity;
  }

  /** @param {Bundle} bundle @param {number} atMs */
  addBundle(bundle, atMs) {
    if (this.round === null || bundle.epoch !== (this.round.epoch & 0xffff)) return;
    this.recording = (bundle.flags & FLAG_NOT_RECORDING) === 0;
    this.#timeline.push(bundle);
    if (this.clock.known) this.#head.arrived(bundle.timeMs, this.clock.now(atMs));
  }

  /** What to show at local time `nowMs`. @param {number} nowMs @returns {Scene | null} null before the first round */
  show(nowMs) {
    if (this.round === null) return null;
    const live = this.phase === "playing" && this.#held.length === 0;
    if (this.clock.known) {
      this.#timeMs = this.#head.advance(this.clock.now(nowMs), this.#timeline.endMs);
      if (!live) this.#timeMs = Math.min(this.#timeMs, this.#timeline.endMs);
    }
    const events = this.#timeline.takeEvents(this.#timeMs);
    const frame = this.#timeline.at(this.#timeMs);
    const stalled = live && frame !== null && frame.tick > 0 && this.#timeMs >= this.#timeline.endMs + EXTRAPOLATE_MS;
    this.#release(nowMs);
    return { view: frame ?? startView(this.round.map), tick: frame?.tick ?? 0, stalled, events };
  }

  /** Applies the messages that the picture has caught up with. @param {number} nowMs */
  #release(nowMs) {
    while (this.#held.length > 0) {
      const { message, atMs } = this.#held[0];
      if (this.#overtakes(message) && nowMs - atMs < HOLD_MS) return;
      this.#held.shift();
      this.#apply(message);
    }
  }

  /** Seconds until the countdown or the pause ends, 0 when neither runs. @param {number} nowMs */
  secondsLeft(nowMs) {
    if (this.room === null || this.room.until_ms === 0 || !this.clock.known) return 0;
    return Math.max(0, (this.room.until_ms - this.clock.now(nowMs)) / 1000);
  }

  /** After a hidden tab: what was missed is not played back. */
  skipToNow() {
    this.#head.reset();
  }
}
