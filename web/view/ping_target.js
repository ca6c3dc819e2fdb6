// What a ping points at: the item that is held, in front of the robot or under a finger, else the robot's own place.

import { ARENA_HALF, ROBOT_RADIUS } from "../messages.js";

/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").View} View */
/** @typedef {{x: number, y: number}} Point  arena units */

export const OWN_PLACE = -1;
const AHEAD = 0.6; // arena units from the robot's edge to the item's within which an item is "in front"
const SIDEWAYS = Math.PI / 3; // rad to either side of where the robot faces
const FINGER = 0.1; // arena units around an item that still count as a tap on it

/**
 * The item that the robot of a seat asks for help with, OWN_PLACE for none.
 * @param {GameMap} map @param {View} view @param {number} seat
 */
export function itemAhead(map, view, seat) {
  if (view.held[seat] >= 0) return view.held[seat];
  const [x, y, angle] = view.poses[seat];
  return nearest(map, view, { x, y }, (item, gap) => {
    const [ix, iy] = view.poses[item + 2];
    const turn = Math.atan2(x - ix, iy - y) - angle; // an angle of 0 looks up, counter-clockwise
    return gap <= ROBOT_RADIUS + AHEAD && Math.abs(Math.atan2(Math.sin(turn), Math.cos(turn))) <= SIDEWAYS;
  });
}

/**
 * What a tap on the arena points at: an item, OWN_PLACE on the own robot; null elsewhere.
 * @param {GameMap} map @param {View} view @param {number} seat @param {Point} point
 */
export function itemAt(map, view, seat, point) {
  const item = nearest(map, view, point, (_, gap) => gap <= FINGER);
  if (item !== OWN_PLACE) return item;
  const [x, y] = view.poses[seat];
  return Math.hypot(point.x - x, point.y - y) <= ROBOT_RADIUS + FINGER ? OWN_PLACE : null;
}

/** Where a pointer is in the arena. @param {DOMRect} box  of the canvas @param {Point} pointer  in the window */
export function arenaPoint(box, pointer) {
  const scale = (2 * ARENA_HALF) / box.width;
  return { x: (pointer.x - box.left) * scale - ARENA_HALF, y: ARENA_HALF - (pointer.y - box.top) * scale };
}

/**
 * The nearest item that is still to be brought in and meets the condition; OWN_PLACE for none.
 * @param {GameMap} map @param {View} view @param {Point} from
 * @param {(item: number, gap: number) => boolean} meets  gap: arena units from the point to the item's edge
 */
function nearest(map, view, from, meets) {
  let [found, least] = [OWN_PLACE, Infinity];
  for (const [item, { scale }] of map.items.entries()) {
    const [x, y] = view.poses[item + 2];
    const gap = Math.hypot(x - from.x, y - from.y) - scale;
    if (gap >= least || view.delivered[item] || !meets(item, gap)) continue;
    [found, least] = [item, gap];
  }
  return found;
}
