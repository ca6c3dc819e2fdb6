// What does not move: goals and walls below everything, the edge above it, each cached in an offscreen canvas per page
// canvas, size and theme.

import { WALL_MARGIN } from "../messages.js";
import { ArenaContext } from "./arena_context.js";

const CORNER_PX = 12; // CSS pixels, as --radius

/** @typedef {import("../core/colours.js").Theme} Theme */
/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").Rect} Rect */
/** @typedef {OffscreenCanvas | HTMLCanvasElement} HiddenCanvas */
/** @typedef {{map: GameMap, theme: Theme, side: number, canvas: HiddenCanvas}} Layer */
/** @type {WeakMap<HTMLCanvasElement, Layer>} */
const layers = new WeakMap();
/** @type {WeakMap<HTMLCanvasElement, Omit<Layer, "map">>} */
const edges = new WeakMap();

/** @param {ArenaContext} page  of the canvas that it is for @param {GameMap} map @returns {HiddenCanvas} */
export function staticLayer({ ctx: shown, theme, density }, map) {
  const page = /** @type {HTMLCanvasElement} */ (shown.canvas);
  const known = layers.get(page);
  const side = page.width;
  if (known?.map === map && known.theme === theme && known.side === side) return known.canvas;
  const { layer, arena } = emptyLayer(shown, theme, density);
  const { ctx } = arena;
  ctx.fillStyle = theme.surface;
  ctx.fillRect(0, 0, side, side);
  for (const goal of map.goals) drawGoal(arena, goal);
  for (const wall of map.walls) drawWall(arena, wall);
  layers.set(page, { map, theme, side, canvas: layer });
  return layer;
}

/** The edge alone, to be copied over a part of the picture. @param {ArenaContext} page @returns {HiddenCanvas} */
export function edgeLayer({ ctx: shown, theme, density }) {
  const page = /** @type {HTMLCanvasElement} */ (shown.canvas);
  const known = edges.get(page);
  const side = page.width;
  if (known?.theme === theme && known.side === side) return known.canvas;
  const { layer, arena } = emptyLayer(shown, theme, density);
  drawEdge(arena);
  edges.set(page, { theme, side, canvas: layer });
  return layer;
}

/** The edge of the arena; drawn, because a round clip costs WebKit 60 ms per picture. @param {ArenaContext} arena */
export function drawEdge({ ctx, theme, density }) {
  const side = ctx.canvas.width;
  const [half, radius] = [density / 2, CORNER_PX * density];
  ctx.beginPath();
  ctx.rect(0, 0, side, side);
  roundRect(ctx, [half, half, side - density, side - density], radius - half);
  ctx.fillStyle = theme.bg;
  ctx.fill("evenodd");
  ctx.beginPath();
  roundRect(ctx, [half, half, side - density, side - density], radius - half);
  ctx.strokeStyle = theme.line;
  ctx.lineWidth = density;
  ctx.stroke();
}

/**
 * A canvas as large as the one that is shown, in the same memory.
 * @param {ArenaContext["ctx"]} shown @param {Theme} theme @param {number} density
 */
function emptyLayer(shown, theme, density) {
  const side = shown.canvas.width;
  const { willReadFrequently } = /** @type {CanvasRenderingContext2D} */ (shown).getContextAttributes();
  const layer = hiddenCanvas(side);
  const ctx = /** @type {ArenaContext["ctx"] | null} */ (layer.getContext("2d", { willReadFrequently }));
  if (ctx === null) throw new Error("this browser cannot draw on a canvas");
  return { layer, arena: new ArenaContext(ctx, theme, side, density) };
}

/** Safari before 16.4 draws offscreen on a canvas without a place in the page. @param {number} side */
function hiddenCanvas(side) {
  if (typeof OffscreenCanvas === "function") return new OffscreenCanvas(side, side);
  return Object.assign(document.createElement("canvas"), { width: side, height: side });
}

/**
 * roundRect, which Safari has from 16 on.
 * @param {ArenaContext["ctx"]} ctx @param {[number, number, number, number]} rect left, top, width, height
 * @param {number} radius
 */
function roundRect(ctx, [left, top, width, height], radius) {
  if ("roundRect" in ctx) return ctx.roundRect(left, top, width, height, radius);
  const [right, bottom] = [left + width, top + height];
  const path = /** @type {CanvasPath} */ (ctx);
  path.moveTo(left + radius, top);
  path.arcTo(right, top, right, bottom, radius);
  path.arcTo(right, bottom, left, bottom, radius);
  path.arcTo(left, bottom, left, top, radius);
  path.arcTo(left, top, right, top, radius);
  path.closePath();
}

/**
 * @param {ArenaContext} arena
 * @param {Rect} rect
 * @param {number} margin arena units
 * @returns {[number, number, number, number]}
 */
function pixels(arena, rect, margin) {
  const [left, top] = arena.at(Math.min(rect.x0, rect.x1) - margin, Math.max(rect.y0, rect.y1) + margin);
  const [right, bottom] = arena.at(Math.max(rect.x0, rect.x1) + margin, Math.min(rect.y0, rect.y1) - margin);
  return [left, top, right - left, bottom - top];
}

/** @param {ArenaContext} arena @param {Rect} goal */
function drawGoal(arena, goal) {
  const { ctx, theme } = arena;
  const [left, top, width, height] = pixels(arena, goal, 0);
  ctx.save();
  ctx.beginPath();
  roundRect(ctx, [left, top, width, height], 0.025 * arena.unit);
  ctx.fillStyle = theme.goal;
  ctx.fill();
  ctx.clip();
  ctx.strokeStyle = theme["goal-hatch"];
  ctx.lineWidth = 0.011 * arena.unit;
  ctx.beginPath();
  for (let x = left - height; x < left + width; x += 0.06 * arena.unit) {
    ctx.moveTo(x, top + height);
    ctx.lineTo(x + height, top);
  }
  ctx.stroke();
  ctx.restore();
  const inset = arena.hair;
  ctx.beginPath();
  roundRect(ctx, [left + inset, top + inset, width - 2 * inset, height - 2 * inset], 0.022 * arena.unit);
  ctx.strokeStyle = theme["goal-edge"];
  ctx.lineWidth = 2 * arena.hair;
  ctx.setLineDash([0.026 * arena.unit, 0.015 * arena.unit]);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** @param {ArenaContext} arena @param {Rect} wall */
function drawWall(arena, wall) {
  arena.ctx.beginPath();
  roundRect(arena.ctx, pixels(arena, wall, WALL_MARGIN), WALL_MARGIN * arena.unit);
  arena.ctx.fillStyle = arena.theme.wall;
  arena.ctx.fill();
}
