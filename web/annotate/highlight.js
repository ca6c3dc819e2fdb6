// @ts-check
/*
 * Marks in the arena who is judged and about which item: a ring around the robot, a dashed one around the item.
 */

import { currentTheme } from "../core/colours.js";
import { ROBOT_RADIUS } from "../messages.js";
import { outline } from "../shapes.js";
import { ArenaContext } from "../view/arena_context.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */

const AROUND = 0.05; // arena units between a ring and what it surrounds

/**
 * @param {CanvasRenderingContext2D} ctx @param {GameMap} map @param {View} view
 * @param {{seat: number, item: number}} what
 */
export function highlight(ctx, map, view, { seat, item }) {
  const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
  ring(arena, view.poses[seat], ROBOT_RADIUS, false);
  const { shape, scale } = map.items[item];
  const corners = outline(shape, scale).map(([x, y]) => Math.hypot(x, y));
  ring(arena, view.poses[item + 2], Math.max(scale, ...corners), true);
}

/**
 * @param {ArenaContext} arena @param {import("../view/render.js").Triple} pose
 * @param {number} radius arena units
 * @param {boolean} dashed
 */
function ring(arena, [x, y], radius, dashed) {
  const { ctx, theme, unit, hair } = arena;
  arena.around([x, y, 0], () => {
    for (const [width, paint] of /** @type {[number, string][]} */ ([
      [7, theme.surface],
      [4, theme.attention],
    ])) {
      arena.circle((radius + AROUND) * unit);
      if (dashed) ctx.setLineDash([0.06 * unit, 0.05 * unit]);
      Object.assign(ctx, { strokeStyle: paint, lineWidth: width * hair });
      ctx.stroke();
    }
  });
}
