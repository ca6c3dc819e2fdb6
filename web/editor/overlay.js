// @ts-check
/*
 * What the editor draws over the arena: the grid, what is selected with its handles, and where a fault is.
 */

import { currentTheme } from "../core/colours.js";
import { ARENA_HALF } from "../messages.js";
import { ArenaContext } from "../view/arena_context.js";
import { drawItem } from "../view/item.js";
import { context2d, drawScene, startView } from "../view/render.js";
import { drawRobot } from "../view/robot.js";
import { reach, sides, thing, middle } from "./parts.js";
import { handlesOf } from "./pointing.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */
/** @typedef {import("../view/render.js").View} View */

const GRID = 0.2;
const MARGIN = 0.025; // of the outline of what is selected
const FAULT_MARGIN = 0.05; // so that both outlines are seen

/**
 * @param {HTMLCanvasElement} canvas @param {GameMap} map
 * @param {{selected: Part | null, faulty: readonly Part[], grid: boolean}} state
 */
export function drawEditor(canvas, map, { selected, faulty, grid }) {
  const ctx = context2d(canvas);
  drawScene(ctx, map, startView(map));
  const arena = new ArenaContext(ctx, currentTheme(), canvas.width);
  if (grid) {
    drawGrid(arena);
    drawBodies(arena, map);
  }
  for (const part of faulty) outlinePart(arena, map, part, FAULT_MARGIN, arena.theme.bad, [0.03, 0.02]);
  if (!selected) return;
  outlinePart(arena, map, selected, MARGIN, arena.theme.focus, []);
  drawHandles(arena, map, selected);
}

/** A moment of a trial. @param {HTMLCanvasElement} canvas @param {GameMap} map @param {View} view */
export function drawMoment(canvas, map, view) {
  drawScene(context2d(canvas), map, view);
}

/**
 * The grid lies on the floor: items and robots once more, above it.
 * @param {ArenaContext} arena
 * @param {GameMap} map
 */
function drawBodies(arena, map) {
  const view = startView(map);
  map.items.forEach((item, index) => drawItem(arena, item, view, index, {}));
  for (const seat of [0, 1]) drawRobot(arena, view.poses[seat], seat, {});
}

/** @param {ArenaContext} arena */
function drawGrid(arena) {
  const { ctx, theme } = arena;
  ctx.save();
  ctx.globalAlpha = 0.16;
  ctx.strokeStyle = theme.ink;
  ctx.lineWidth = arena.hair;
  ctx.beginPath();
  for (let line = -ARENA_HALF + GRID; line < ARENA_HALF - GRID / 2; line += GRID) {
    ctx.moveTo(...arena.at(line, -ARENA_HALF));
    ctx.lineTo(...arena.at(line, ARENA_HALF));
    ctx.moveTo(...arena.at(-ARENA_HALF, line));
    ctx.lineTo(...arena.at(ARENA_HALF, line));
  }
  ctx.stroke();
  ctx.restore();
}

/**
 * @param {ArenaContext} arena
 * @param {GameMap} map
 * @param {Part} part
 * @param {number} margin
 * @param {string} colour
 * @param {number[]} dash
 */
function outlinePart(arena, map, part, margin, colour, dash) {
  const it = thing(map, part);
  if (it === undefined) return;
  const { ctx } = arena;
  ctx.save();
  ctx.strokeStyle = colour;
  ctx.lineWidth = 3 * arena.hair;
  ctx.setLineDash(dash.map((length) => length * arena.unit));
  ctx.beginPath();
  if ("x0" in it) {
    const { left, bottom, right, top } = sides(it);
    const [x, y] = arena.at(left - margin, top + margin);
    ctx.rect(x, y, (right - left + 2 * margin) * arena.unit, (top - bottom + 2 * margin) * arena.unit);
  } else ctx.arc(...arena.at(it.x, it.y), (reach(map, part) + margin) * arena.unit, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.restore();
}

/** @param {ArenaContext} arena @param {GameMap} map @param {Part} part */
function drawHandles(arena, map, part) {
  const { ctx, theme } = arena;
  const size = 6 * Math.max(arena.hair, devicePixelRatio);
  for (const handle of handlesOf(map, part)) {
    if (handle.name === "turn") {
      const from = middle(map, part);
      ctx.beginPath();
      ctx.moveTo(...arena.at(from.x, from.y));
      ctx.lineTo(...arena.at(handle.x, handle.y));
      ctx.strokeStyle = theme.focus;
      ctx.lineWidth = 1.5 * arena.hair;
      ctx.stroke();
    }
    const [x, y] = arena.at(handle.x, handle.y);
    ctx.beginPath();
    if (handle.name === "turn") ctx.arc(x, y, size, 0, 2 * Math.PI);
    else ctx.rect(x - size, y - size, 2 * size, 2 * size);
    ctx.fillStyle = theme.surface;
    ctx.strokeStyle = theme.focus;
    ctx.lineWidth = 2.5 * arena.hair;
    ctx.fill();
    ctx.stroke();
  }
}
