// What a grab would take: the rule of world/grab.py, from the poses on the screen. Runs in each frame, so it makes no
// objects: outlines are kept per item, and the rest is arithmetic.

import { CORNER_FRACTION, REACH, REACH_TOLERANCE } from "../messages.js";
import { outline } from "../shapes.js";

/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").Item} Item */
/** @typedef {import("./render.js").View} View */

/** @typedef {{corners: Float64Array, radius: number}} Solid  x, y of each corner; by how much it exceeds them */
/** @type {WeakMap<Item, Solid>} */
const solids = new WeakMap();

/**
 * The item that `seat` would take now, -1 for none: the nearest whose surface is in reach of the point before the
 * robot, but no small item that the partner holds.
 * @param {GameMap} map @param {View} view @param {number} seat
 */
export function itemInReach(map, view, seat) {
  if (view.held[seat] >= 0) return -1;
  const pose = view.poses[seat];
  const x = pose[0] - REACH * Math.sin(pose[2]);
  const y = pose[1] + REACH * Math.cos(pose[2]);
  let found = -1;
  let nearest = REACH_TOLERANCE;
  for (let index = 0; index < map.items.length; index += 1) {
    const item = map.items[index];
    if (item.size === "small" && view.held[1 - seat] === index) continue;
    const gap = gapTo(item, view.poses[index + 2], x, y);
    if (gap < nearest) {
      nearest = gap;
      found = index;
    }
  }
  return found;
}

/**
 * Signed distance of a point to an item's surface.
 * @param {Item} item @param {readonly number[]} pose @param {number} x @param {number} y
 */
function gapTo(item, pose, x, y) {
  const dx = x - pose[0];
  const dy = y - pose[1];
  if (item.shape === "circle") return Math.hypot(dx, dy) - item.scale;
  const cos = Math.cos(pose[2]);
  const sin = Math.sin(pose[2]);
  const solid = solidOf(item);
  return polygonGap(solid.corners, cos * dx + sin * dy, cos * dy - sin * dx) - solid.radius;
}

/** @param {Item} item @returns {Solid} */
function solidOf(item) {
  let solid = solids.get(item);
  if (solid === undefined) {
    const isBox = item.shape === "square" || item.shape === "rectangle";
    const radius = isBox ? CORNER_FRACTION * Math.sqrt(Math.PI) * item.scale : 0;
    solid = { corners: Float64Array.from(outline(item.shape, item.scale).flat()), radius };
    solids.set(item, solid);
  }
  return solid;
}

/** Negative inside. @param {Float64Array} corners @param {number} x @param {number} y */
function polygonGap(corners, x, y) {
  let nearest = Infinity;
  let inside = false;
  for (let at = 0; at < corners.length; at += 2) {
    const next = (at + 2) % corners.length;
    const ax = corners[at];
    const ay = corners[at + 1];
    const ex = corners[next] - ax;
    const ey = corners[next + 1] - ay;
    const along = ((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey);
    const share = along < 0 ? 0 : along > 1 ? 1 : along;
    nearest = Math.min(nearest, Math.hypot(x - ax - share * ex, y - ay - share * ey));
    if (ay > y !== ay + ey > y && x < ax + ((y - ay) * ex) / ey) inside = !inside;
  }
  return inside ? -nearest : nearest;
}
