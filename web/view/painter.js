// @ts-check
/*
 * Draws a scene again only where something changed since the last picture. Without a graphics processor a browser
 * copies to the screen what was drawn on, and on a large canvas that costs more than the drawing.
 */

import { currentTheme } from "../core/colours.js";
import { ROBOT_RADIUS } from "../messages.js";
import { radiusOf } from "../shapes.js";
import { ArenaContext } from "./arena_context.js";
import { apart, union } from "./box.js";
import { densityOf, drawScene } from "./render.js";

/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").Options} Options */
/** @typedef {import("./render.js").View} View */
/** @typedef {import("./box.js").Box} Box */
/** @typedef {{key: string, box: Box}} Body  what a body looks like, and all the room that its drawing may take */

const MOST = 0.4; // of the canvas; where more has changed, all of it is drawn
const AROUND_ITEM = 0.06; // arena units: the ring "needs two", at its largest
const AROUND_ROBOT = 0.13; // arena units: the arrow of a stick
const GRIP = 0.03; // arena units to each side
const LINES = 6; // half the width of the widest outline, in hairs

export class Painter {
  /** @type {{map: GameMap, theme: unknown, side: number, bodies: Body[], wholly: boolean} | null} */
  #last = null;

  /** @param {CanvasRenderingContext2D} ctx  nobody else draws on it, but over pictures that are drawn wholly */
  constructor(ctx) {
    this.ctx = ctx;
  }

  /**
   * @param {GameMap} map @param {View} view @param {Options} options
   * @param {boolean} wholly  something is drawn besides the bodies: this picture and the next one are drawn wholly
   */
  paint(map, view, options, wholly) {
    const last = this.#last;
    const theme = options.theme ?? currentTheme();
    const side = this.ctx.canvas.width;
    const bodies = bodiesOf(new ArenaContext(this.ctx, theme, side, densityOf(this.ctx.canvas)), map, view, options);
    this.#last = { map, theme, side, bodies, wholly };
    const known = last !== null && last.map === map && last.theme === theme && last.side === side;
    const places = known && !wholly && !last.wholly ? changedPlaces(last.bodies, bodies, side) : null;
    if (places === null || areaOf(places) > MOST * side * side) drawScene(this.ctx, map, view, options);
    else if (places.length > 0) drawScene(this.ctx, map, view, { ...options, damage: { places, bodies } });
  }
}

/**
 * Where bodies were and are that look different now or stand elsewhere, within the canvas; no two places overlap.
 * @param {readonly Body[]} before @param {readonly Body[]} now @param {number} side pixels @returns {Box[]}
 */
export function changedPlaces(before, now, side) {
  const places = now
    .flatMap(({ key, box }, index) => (key === before[index].key ? [] : [before[index].box, box]))
    .map(({ left, top, right, bottom }) => ({
      left: Math.max(0, left),
      top: Math.max(0, top),
      right: Math.min(side, right),
      bottom: Math.min(side, bottom),
    }))
    .filter(({ left, top, right, bottom }) => left < right && top < bottom);
  return apart(places);
}

/** @param {readonly Box[]} boxes */
function areaOf(boxes) {
  return boxes.reduce((sum, { left, top, right, bottom }) => sum + (right - left) * (bottom - top), 0);
}

/**
 * Blue and red, then the items, as `drawScene` draws them.
 * @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {Options} options @returns {Body[]}
 */
export function bodiesOf(arena, map, view, options) {
  const robots = [0, 1].map((seat) => robotBody(arena, view, seat, options));
  return [...robots, ...map.items.map((_, index) => itemBody(arena, map, view, index, options))];
}

/** @param {ArenaContext} arena @param {View} view @param {number} seat @param {Options} options @returns {Body} */
function robotBody(arena, view, seat, { intents, own, misses }) {
  const [pose, held, intent] = [view.poses[seat], view.held[seat], intents?.[seat]];
  const item = held < 0 ? null : view.poses[held + 2];
  const around = circleBox(arena, pose, ROBOT_RADIUS + AROUND_ROBOT);
  return {
    key: [pose, item, intent?.x, intent?.y, own?.includes(seat), misses?.[seat]].join(),
    box: item === null ? around : union(around, circleBox(arena, item, GRIP)),
  };
}

/**
 * @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {number} index @param {Options} options
 * @returns {Body}
 */
function itemBody(arena, map, view, index, { reach, pulse }) {
  const { shape, scale, size } = map.items[index];
  const pose = view.poses[index + 2];
  const holders = [0, 1].filter((seat) => view.held[seat] === index);
  const waits = size === "large" && holders.length === 1 ? [pulse, view.poses[holders[0]]] : null;
  return {
    key: [pose, holders.join("+"), view.delivered[index], reach?.indexOf(index), waits].join(),
    box: circleBox(arena, pose, radiusOf(shape, scale) + AROUND_ITEM),
  };
}

/** @param {ArenaContext} arena @param {readonly number[]} pose @param {number} radius arena units @returns {Box} */
function circleBox(arena, [x, y], radius) {
  const [across, down] = arena.at(x, y);
  const reach = radius * arena.unit + LINES * arena.hair + 1;
  return {
    left: Math.floor(across - reach),
    top: Math.floor(down - reach),
    right: Math.ceil(across + reach),
    bottom: Math.ceil(down + reach),
  };
}
