// @ts-check
/*
 * How hard a map is for somebody who plays for the first time: 1 easy, 2 medium, 3 hard. It follows from the map alone,
 * so a map of one's own has it too.
 */

import { ARENA_HALF } from "../messages.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */

const ARENA = (2 * ARENA_HALF) ** 2;
const FULL_OF_WALLS = 0.2; // share of the arena: the two get in each other's way
const CORRIDOR = 0.5; // share of the arena: most items have to be passed on
const MANY_WALLS = 4;

/** @param {GameMap} map @returns {1 | 2 | 3} */
export function difficulty({ walls, items }) {
  const filled = walls.reduce((sum, { x0, y0, x1, y1 }) => sum + Math.abs((x1 - x0) * (y1 - y0)), 0) / ARENA;
  const large = items.filter(({ size }) => size === "large").length; // both lift at the same time and move as one
  const around = large === items.length && walls.length > 0; // nothing else to do than to steer one around
  const narrow = walls.length >= MANY_WALLS || filled > FULL_OF_WALLS;
  const points = Number(large > 0) + Number(around) + Number(narrow) + Number(filled > CORRIDOR);
  return /** @type {1 | 2 | 3} */ (Math.min(3, 1 + points));
}
