// What never moves, the goals and walls of a map, kept in an offscreen canvas per page canvas, size and theme.

import { Pen } from "./pen.js";

const WALL_MARGIN = 0.01; // a wall is this much thicker than its rectangle, as the official world makes it

/** @typedef {import("../core/colours.js").Theme} Theme */
/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").Rect} Rect */
/** @typedef {{map: GameMap, theme: Theme, side: number, canvas: OffscreenCanvas}} Layer */
/** @type {WeakMap<HTMLCanvasElement, Layer>} */
const layers = new WeakMap();

/** @param {HTMLCanvasElement} canvas @param {GameMap} map @param {Theme} theme @returns {OffscreenCanvas} */
export function staticLayer(canvas, map, theme) {
  const known = layers.get(canvas);
  const side = canvas.width;
  if (known?.map === map && known.theme === theme && known.side === side) return known.canvas;
  const layer = new OffscreenCanvas(side, side);
  const ctx = layer.getContext("2d");
  if (ctx === null) throw new Error("this browser cannot draw on a canvas");
  const pen = new Pen(ctx, theme, side);
  ctx.fillStyle = theme.surface;
  ctx.fillRect(0, 0, side, side);
  for (const goal of map.goals) drawGoal(pen, goal);
  for (const wall of map.walls) drawWall(pen, wall);
  layers.set(canvas, { map, theme, side, canvas: layer });
  return layer;
}

/**
 * @param {Pen} pen
 * @param {Rect} rect
 * @param {number} margin arena units
 * @returns {[number, number, number, number]}
 */
function pixels(pen, rect, margin) {
  const [left, top] = pen.at(Math.min(rect.x0, rect.x1) - margin, Math.max(rect.y0, rect.y1) + margin);
  const [right, bottom] = pen.at(Math.max(rect.x0, rect.x1) + margin, Math.min(rect.y0, rect.y1) - margin);
  return [left, top, right - left, bottom - top];
}

/** @param {Pen} pen @param {Rect} goal */
function drawGoal(pen, goal) {
  const { ctx, theme } = pen;
  const [left, top, width, height] = pixels(pen, goal, 0);
  ctx.save();
  ctx.beginPath();
  ctx.roundRect(left, top, width, height, 0.025 * pen.unit);
  ctx.fillStyle = theme.goal;
  ctx.fill();
  ctx.clip();
  ctx.strokeStyle = theme["goal-hatch"];
  ctx.lineWidth = 0.011 * pen.unit;
  ctx.beginPath();
  for (let x = left - height; x < left + width; x += 0.06 * pen.unit) {
    ctx.moveTo(x, top + height);
    ctx.lineTo(x + height, top);
  }
  ctx.stroke();
  ctx.restore();
  const inset = pen.hair;
  ctx.beginPath();
  ctx.roundRect(left + inset, top + inset, width - 2 * inset, height - 2 * inset, 0.022 * pen.unit);
  ctx.strokeStyle = theme["goal-edge"];
  ctx.lineWidth = 2 * pen.hair;
  ctx.setLineDash([0.026 * pen.unit, 0.015 * pen.unit]);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** @param {Pen} pen @param {Rect} wall */
function drawWall(pen, wall) {
  pen.ctx.beginPath();
  pen.ctx.roundRect(...pixels(pen, wall, WALL_MARGIN), WALL_MARGIN * pen.unit);
  pen.ctx.fillStyle = pen.theme.wall;
  pen.ctx.fill();
}
