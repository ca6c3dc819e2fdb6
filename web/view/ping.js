// Draws a ping: a ring around the item or the place where somebody asks for help, with an exclamation mark above it.

import { readable } from "../core/colours.js";
import { ARENA_HALF, ROBOT_RADIUS } from "../messages.js";
import { outline } from "../shapes.js";

/** @typedef {import("./arena_context.js").ArenaContext} ArenaContext */
/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").View} View */
/** @typedef {{seat: number, item: number, x: number, y: number}} Ping  item -1: the place x, y [arena units] */

const AROUND = 0.045; // arena units between the ring and what it surrounds
const SWELLS = 0.05; // arena units that the ring grows and shrinks
const MARK = 0.075; // radius of the mark, arena units

/**
 * @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {Ping} ping
 * @param {number} pulse  0 to 1: how far the ring is from its smallest size; constant without motion
 */
export function drawPing(arena, map, view, ping, pulse) {
  const { x, y, radius } = placeOf(map, view, ping);
  const { ctx, theme, unit, hair } = arena;
  const colour = ping.seat === 0 ? theme.blue : theme.red;
  const ring = radius + AROUND + SWELLS * pulse;
  arena.around([x, y, 0], () => {
    // The ink under the colour keeps the ring visible on every item and in every theme.
    for (const [width, paint] of /** @type {[number, string][]} */ ([
      [8, theme.ink],
      [4, colour],
    ])) {
      arena.circle(ring * unit);
      ctx.strokeStyle = paint;
      ctx.lineWidth = width * hair;
      if (ping.seat === 1) ctx.setLineDash([0.09 * unit, 0.04 * unit]);
      ctx.stroke();
      ctx.setLineDash([]);
    }
  });
  drawMark(arena, x, y, radius + AROUND + SWELLS, colour);
}

/**
 * The exclamation mark stands above the ring, or below it at the upper edge of the arena.
 * @param {ArenaContext} arena @param {number} x @param {number} y @param {number} away @param {string} colour
 */
function drawMark(arena, x, y, away, colour) {
  const { ctx, theme, unit, hair } = arena;
  const above = y + away + 2 * MARK < ARENA_HALF ? 1 : -1;
  const within = ARENA_HALF - MARK;
  arena.around([Math.min(within, Math.max(-within, x)), y + above * (away + MARK), 0], () => {
    arena.circle(MARK * unit);
    ctx.fillStyle = colour;
    ctx.fill();
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = 2 * hair;
    ctx.stroke();
    arena.label("!", 0.11 * unit, readable(colour, "#ffffff", "#18212c"));
  });
}

/**
 * Where a ping is shown now, and the radius of what it surrounds; an item has perhaps moved.
 * @param {GameMap} map @param {View} view @param {Ping} ping
 */
function placeOf(map, view, ping) {
  const pose = view.poses[ping.item + 2];
  const item = map.items[ping.item];
  if (pose === undefined || item === undefined) return { x: ping.x, y: ping.y, radius: ROBOT_RADIUS };
  const corners = outline(item.shape, item.scale).map(([dx, dy]) => Math.hypot(dx, dy));
  return { x: pose[0], y: pose[1], radius: Math.max(item.scale, ...corners) };
}
