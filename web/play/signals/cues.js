// Cues over the arena: what is in reach, a grab that missed, a delivery, and the marks of the tutorial. Keeps numbers
// only and makes no objects per frame. Without motion the cues stand still.

import { EVENT } from "../../messages.js";
import { itemInReach } from "../../view/reach.js";
import { radiusOf } from "../../shapes.js";

/** @typedef {import("../game.js").Game} Game */
/** @typedef {import("../game.js").Scene} Scene */
/** @typedef {import("../../view/arena_context.js").ArenaContext} ArenaContext */

export const MISS_MS = 150;
const SHAKES = 2; // there and back within MISS_MS
const DELIVERY_MS = 700;

export class Cues {
  reach = [-1, -1];
  misses = [0, 0];
  missed = 0; // grabs that missed so far, for tests
  #missedAtMs = [-Infinity, -Infinity];
  /** @type {number[]} per item */
  #deliveredAtMs = [];
  #nowMs = 0;
  #pulse = 1;
  #calm = false;
  /** @type {Game} */
  #game;
  /** @type {Scene | null} */
  #scene = null;

  /** @param {Game} game */
  constructor(game) {
    this.#game = game;
  }

  /** Once per frame. @param {Scene} scene @param {number} nowMs @param {number} pulse @param {boolean} calm */
  update(scene, nowMs, pulse, calm) {
    this.#scene = scene;
    this.#nowMs = nowMs;
    this.#pulse = pulse;
    this.#calm = calm;
    for (const event of scene.events) {
      if (event.code === EVENT.grab_failed && event.seat >= 0) {
        this.#missedAtMs[event.seat] = nowMs;
        this.missed += 1;
      }
      if (event.code === EVENT.delivered) this.#deliveredAtMs[event.item] = nowMs;
      if (event.code === EVENT.undelivered) this.#deliveredAtMs[event.item] = -Infinity;
    }
    const { round, own, phase } = this.#game;
    for (let seat = 0; seat < 2; seat += 1) {
      const shown = round !== null && phase === "playing" && own.includes(seat);
      this.reach[seat] = shown ? itemInReach(round.map, scene.view, seat) : -1;
      this.misses[seat] = missAt(nowMs - this.#missedAtMs[seat], calm);
    }
  }

  /** Whether `over` draws anything in this picture. */
  get marks() {
    const fades = this.#deliveredAtMs.some((atMs) => this.#nowMs - atMs < DELIVERY_MS);
    return fades || (this.#game.tutorial !== null && !this.#game.tutorial.finished);
  }

  /** @param {ArenaContext} arena */
  over = (arena) => {
    const { round, tutorial, phase } = this.#game;
    const scene = this.#scene;
    if (round === null || scene === null) return;
    for (let item = 0; item < round.map.items.length; item += 1) {
      const share = (this.#nowMs - (this.#deliveredAtMs[item] ?? -Infinity)) / DELIVERY_MS;
      if (share < 1) this.#drawDelivery(arena, item, this.#calm ? 0.5 : share);
    }
    if (tutorial !== null && !tutorial.finished && phase !== "series_over") this.#drawTutorial(arena, tutorial);
  };

  /** A ring that grows and fades. @param {ArenaContext} arena @param {number} item @param {number} share of its time */
  #drawDelivery(arena, item, share) {
    arena.ctx.globalAlpha = 1 - share;
    this.#ringAround(arena, item, 0.03 + 0.14 * share, arena.theme.ok, 5);
    arena.ctx.globalAlpha = 1;
  }

  /** @param {ArenaContext} arena @param {import("../../messages.js").Tutorial} tutorial */
  #drawTutorial(arena, tutorial) {
    const { own } = this.#game;
    const { ctx, theme, hair, unit } = arena;
    for (let seat = 0; seat < 2; seat += 1) {
      if (own.length > 0 && !own.includes(seat)) continue;
      const target = tutorial.targets[seat];
      if (target >= 0 && this.#scene?.view.held[seat] !== target)
        this.#ringAround(arena, target, 0.035 + 0.025 * this.#pulse, theme.attention, 5);
      const ring = tutorial.rings[seat];
      if (ring.length === 0) continue;
      const [x, y] = arena.at(ring[0], ring[1]);
      ctx.beginPath();
      ctx.arc(x, y, (ring[2] - 0.02 + 0.02 * this.#pulse) * unit, 0, 2 * Math.PI);
      ctx.strokeStyle = theme.attention;
      ctx.lineWidth = 6 * hair;
      ctx.stroke();
    }
  }

  /**
   * @param {ArenaContext} arena @param {number} item
   * @param {number} gap arena units @param {string} colour @param {number} width hairs
   */
  #ringAround(arena, item, gap, colour, width) {
    const scene = this.#scene;
    const round = this.#game.round;
    if (scene === null || round === null) return;
    const pose = scene.view.poses[item + 2];
    const { shape, scale } = round.map.items[item];
    const [x, y] = arena.at(pose[0], pose[1]);
    arena.ctx.beginPath();
    arena.ctx.arc(x, y, (radiusOf(shape, scale) + gap) * arena.unit, 0, 2 * Math.PI);
    arena.ctx.strokeStyle = colour;
    arena.ctx.lineWidth = width * arena.hair;
    arena.ctx.stroke();
  }
}

/**
 * Where the notch is, -1 to 1, so long after a miss. Without motion it stands aside.
 * @param {number} sinceMs @param {boolean} calm
 */
export function missAt(sinceMs, calm) {
  if (!(sinceMs >= 0 && sinceMs < MISS_MS)) return 0;
  return calm ? 1 : Math.sin((2 * Math.PI * SHAKES * sinceMs) / MISS_MS);
}
