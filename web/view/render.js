// Draws one instant of the world on a canvas: the same picture for the game, the replay and the map cards.
// A pure function of map, view and options; it knows no clock, no socket and no page.

import { currentTheme } from "../core/colours.js";
import { ArenaContext } from "./arena_context.js";
import { overlap } from "./box.js";
import { drawItem } from "./item.js";
import { drawEdge, edgeLayer, staticLayer } from "./layer.js";
import { drawGrip, drawRobot } from "./robot.js";

/** @typedef {import("../core/colours.js").Theme} Theme */
/** @typedef {{x0: number, y0: number, x1: number, y1: number}} Rect */
/**
 * @typedef {object} Item
 * @property {number} id
 * @property {string} shape
 * @property {string} size
 * @property {number} scale
 * @property {number} mass
 * @property {number} x
 * @property {number} y
 * @property {number} angle radians
 */
/** @typedef {{x: number, y: number, angle: number}} Pose */
/**
 * @typedef {object} GameMap  our map JSON
 * @property {string} name
 * @property {string} title
 * @property {number} number
 * @property {string} mode
 * @property {string} description
 * @property {string} [variant]  "challenge2-train-77": shuffled items; a map as designed has none
 * @property {{blue: Pose, red: Pose}} robots
 * @property {Rect[]} walls
 * @property {Rect[]} goals
 * @property {Item[]} items
 */
/** @typedef {readonly [number, number, number]} Triple  x, y [arena units], angle [rad] */
/**
 * @typedef {object} View  one instant
 * @property {readonly Triple[]} poses  the two robots, then the items in the map's order
 * @property {readonly number[]} held  index of the item that blue and red hold, -1 for none
 * @property {readonly boolean[]} delivered  per item
 */
/** @typedef {{x: number, y: number}} Intent  where the stick points: right and up are positive, length 0 to 1 */
/**
 * @typedef {object} Options
 * @property {Theme} [theme]  default: the page's
 * @property {boolean} [plain]  without letters and marks, for small pictures
 * @property {readonly (Intent | null)[]} [intents]  per seat: the arrow of a stick of this page
 * @property {readonly number[]} [own]  seats of this page, to be ringed
 * @property {number} [pulse]  0 to 1: phase of the cue "needs two"; constant without motion
 * @property {readonly number[]} [reach]  per seat the item that a grab would take, -1 for none
 * @property {readonly number[]} [misses]  per seat: how a grab that missed moves the notch, -1 to 1; 0 for none
 * @property {(arena: ArenaContext) => void} [over]  draws what else belongs over the items, and under the robots
 * @property {boolean} [rounded]  with an edge and round corners on the page's ground
 * @property {Damage} [damage]  the only places to draw; the rest of the last picture stays
 */
/** @typedef {import("./box.js").Box} Box */
/** @typedef {{places: readonly Box[], bodies: readonly {box: Box}[]}} Damage  bodies: robots, then items */

/** The view of a map before anything moved. @param {GameMap} map @returns {View} */
export function startView(map) {
  const bodies = [map.robots.blue, map.robots.red, ...map.items];
  return {
    poses: bodies.map(({ x, y, angle }) => /** @type {Triple} */ ([x, y, angle])),
    held: [-1, -1],
    delivered: map.items.map(() => false),
  };
}

/**
 * Sets the canvas' resolution to its size on the page.
 * @param {HTMLCanvasElement} canvas
 * @returns {boolean} whether it changed
 */
export function fitCanvas(canvas) {
  const side = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio));
  if (canvas.width === side && canvas.height === side) return false;
  canvas.width = side;
  canvas.height = side;
  return true;
}

/** A small picture of a map at its start. @param {HTMLCanvasElement} canvas @param {GameMap} map */
export function mapPicture(canvas, map) {
  fitCanvas(canvas);
  drawScene(context2d(canvas), map, startView(map), { plain: canvas.clientWidth < 320 });
}

/** @param {HTMLCanvasElement} canvas @param {boolean} [inMemory] @returns {CanvasRenderingContext2D} */
export function context2d(canvas, inMemory = false) {
  const context = canvas.getContext("2d", { willReadFrequently: inMemory });
  if (context === null) throw new Error("this browser cannot draw on a canvas");
  return context;
}

/**
 * Puts in the place of a canvas one that is painted in main memory. Without a graphics processor WebKit needs 21 ms of
 * processor time per picture then, instead of 35.
 * @param {HTMLCanvasElement} canvas @returns {HTMLCanvasElement}
 */
export function paintInMemory(canvas) {
  const other = /** @type {HTMLCanvasElement} */ (canvas.cloneNode());
  context2d(other, true);
  canvas.replaceWith(other);
  return other;
}

/**
 * Draws `view` over the whole canvas.
 * @param {CanvasRenderingContext2D} ctx @param {GameMap} map @param {View} view @param {Options} [options]
 */
export function drawScene(ctx, map, view, options = {}) {
  const arena = new ArenaContext(ctx, options.theme ?? currentTheme(), ctx.canvas.width, densityOf(ctx.canvas));
  const { damage } = options;
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  ctx.save();
  if (damage) clipTo(ctx, damage.places);
  copyLayer(ctx, staticLayer(arena, map), damage?.places);
  const touched = (/** @type {number} */ body) =>
    !damage || damage.places.some((place) => overlap(place, damage.bodies[body].box));
  const order = map.items.map((_, index) => index).sort((a, b) => Number(isHeld(view, a)) - Number(isHeld(view, b)));
  for (const index of order) if (touched(index + 2)) drawItem(arena, map.items[index], view, index, options);
  options.over?.(arena);
  const seats = [0, 1].filter(touched);
  for (const seat of seats) drawGrip(arena, view, seat);
  for (const seat of seats) drawRobot(arena, view.poses[seat], seat, options);
  if (options.rounded && damage) copyLayer(ctx, edgeLayer(arena), damage.places);
  else if (options.rounded) drawEdge(arena);
  ctx.restore();
}

/** @param {CanvasRenderingContext2D} ctx @param {readonly Box[]} places */
function clipTo(ctx, places) {
  ctx.beginPath();
  for (const { left, top, right, bottom } of places) ctx.rect(left, top, right - left, bottom - top);
  ctx.clip();
}

/** @param {CanvasRenderingContext2D} ctx @param {CanvasImageSource} layer @param {readonly Box[]} [places]  or all */
function copyLayer(ctx, layer, places) {
  if (places === undefined) return ctx.drawImage(layer, 0, 0);
  for (const { left, top, right, bottom } of places) {
    const [width, height] = [right - left, bottom - top];
    ctx.drawImage(layer, left, top, width, height, left, top, width, height);
  }
}

/** Pixels of the canvas per CSS pixel. @param {HTMLCanvasElement} canvas */
export function densityOf(canvas) {
  return canvas.clientWidth > 0 ? canvas.width / canvas.clientWidth : 1;
}

/** @param {View} view @param {number} item */
function isHeld(view, item) {
  return view.held[0] === item || view.held[1] === item;
}
