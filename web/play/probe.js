// Read access to the page for tests and debugging: window.__movingout.

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("./game.js").Scene} Scene */

const GAPS_KEPT = 7200; // two minutes of frames
const JUDGED = 60; // frames after which the page knows whether it draws fast enough
const SLOW_MS = 24; // at 60 Hz every second picture is missed from 25 ms on

export class Probe {
  frames = 0;
  /** @type {number[]} ms between frames drawn, while the page was visible */
  gaps = [];
  #lastMs = NaN;
  /** @type {Scene | null} */
  #scene = null;
  #game;
  #status = "connecting";
  /** @type {readonly (import("../view/render.js").Intent | null)[]} */
  intents = [null, null];
  /** @type {() => readonly import("../messages.js").ShownPing[]} those that are shown now */
  pings = () => [];
  /** @type {import("./signals/cues.js").Cues | null} */
  cues = null;
  /** @type {import("./signals/sounds.js").Sounds | null} */
  sounds = null;

  /** @param {Game} game */
  constructor(game) {
    this.#game = game;
    /** @type {any} */ (window).__movingout = this;
  }

  /**
   * @param {number} nowMs
   * @param {Scene | null} scene
   * @param {string} status
   * @param {readonly (import("../view/render.js").Intent | null)[]} intents
   */
  drawn(nowMs, scene, status, intents) {
    this.frames += 1;
    if (nowMs - this.#lastMs > 0) this.gaps.push(nowMs - this.#lastMs);
    if (this.gaps.length > GAPS_KEPT) this.gaps.shift();
    this.#lastMs = nowMs;
    this.#scene = scene;
    this.#status = status;
    this.intents = intents;
  }

  /** Whether the first pictures came slowly, by their median; known once. */
  get isSlow() {
    if (this.frames !== JUDGED) return false;
    const gaps = this.gaps.slice(-JUDGED / 2).sort((a, b) => a - b);
    return (gaps[Math.floor(gaps.length / 2)] ?? 0) > SLOW_MS;
  }

  /** The page was hidden: the time until the next frame does not count as a gap. */
  hidden() {
    this.#lastMs = NaN;
  }

  get ready() {
    return this.#game.welcome !== null && this.#game.round !== null;
  }

  get status() {
    return this.#status;
  }

  get phase() {
    return this.#game.phase;
  }

  get reason() {
    return this.#game.room?.reason ?? "";
  }

  get tick() {
    return this.#scene?.tick ?? 0;
  }

  get newestTick() {
    return this.#game.newestTick;
  }

  get seats() {
    return this.#game.own;
  }

  get result() {
    return this.#game.result;
  }

  get map() {
    return this.#game.round?.map ?? null;
  }

  get delayMs() {
    return this.#game.delayMs;
  }

  get stalled() {
    return this.#scene?.stalled ?? false;
  }

  /** The robots and items as last drawn, in arena units and radians. */
  entities() {
    const map = this.map;
    const view = this.#scene?.view;
    if (map === null || view === undefined) return { robots: [], items: [] };
    const pose = (/** @type {number} */ body) => ({
      x: view.poses[body][0],
      y: view.poses[body][1],
      angle: view.poses[body][2],
    });
    return {
      robots: [0, 1].map((seat) => ({ ...pose(seat), held: view.held[seat] })),
      items: map.items.map((item, index) => ({
        ...pose(index + 2),
        shape: item.shape,
        size: item.size,
        delivered: view.delivered[index],
      })),
    };
  }
}
