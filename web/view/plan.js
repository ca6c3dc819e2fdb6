// What an agent is trying, as far as its chosen candidate tells: which item it brings where, or goes to. Where that
// cannot be told, nothing is said.

import { distance } from "./candidates.js";

/** @typedef {import("./candidates.js").Decision} Decision */
/** @typedef {import("./candidates.js").Point} Point */
/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").View} View */
/**
 * @typedef {object} Plan
 * @property {"deliver" | "together" | "fetch"} kind  brings an item to a goal, alone or with the partner; goes to one
 * @property {number} item
 * @property {boolean} hopes  the partner is expected to come to the item
 */

const NEARER = 0.03; // arena units; less is no movement
const COMES = 0.1; // arena units that a robot comes nearer to the item that it goes to
const AHEAD = Math.cos(Math.PI / 6); // of the direction to the item and the one of the path
const CLEARLY = 0.1; // by so much of the cosine it is more ahead than any other item

/**
 * @param {GameMap} map @param {View} view  the instant of the decision
 * @param {Decision} decision
 * @returns {Plan | null}
 */
export function planOf(map, view, decision) {
  if (decision.chosen < 0) return null;
  const { seat, moves } = decision;
  const held = view.held[seat];
  if (held >= 0) {
    const place = moves.find(({ item }) => item === held)?.place;
    const now = pointOf(view, held + 2);
    if (place === undefined || goalGap(map, now) - goalGap(map, place) < NEARER) return null;
    return { kind: view.held[1 - seat] === held ? "together" : "deliver", item: held, hopes: false };
  }
  const item = approached(map, view, decision);
  if (item === null) return null;
  const needsTwo = map.items[item].size === "large";
  return { kind: "fetch", item, hopes: needsTwo && partnerComes(view, decision, item) };
}

/**
 * The one item that the own robot clearly goes to.
 * @param {GameMap} map @param {View} view @param {Decision} decision
 */
function approached(map, view, { seat, chosen, ways, own }) {
  const start = pointOf(view, seat);
  const end = own[0]?.at(-1) ?? ways[chosen]?.at(-1);
  if (end === undefined || distance(start, end) < COMES) return null;
  const ahead = map.items
    .map((_, item) => ({ item, ahead: cosine(start, end, pointOf(view, item + 2)) }))
    .filter(({ item }) => !view.delivered[item] && view.held[1 - seat] !== item)
    .sort((one, other) => other.ahead - one.ahead);
  const [best, next] = ahead;
  if (best === undefined || best.ahead < AHEAD || (next && best.ahead - next.ahead < CLEARLY)) return null;
  const place = pointOf(view, best.item + 2);
  return distance(start, place) - distance(end, place) >= COMES ? best.item : null;
}

/**
 * Whether the partner, by most predictions, comes nearer to the item.
 * @param {View} view @param {Decision} decision @param {number} item
 */
function partnerComes(view, { seat, partner }, item) {
  const [start, place] = [pointOf(view, 1 - seat), pointOf(view, item + 2)];
  const come = partner.filter((way) => distance(start, place) - distance(way.at(-1) ?? start, place) >= COMES);
  return partner.length > 0 && 2 * come.length > partner.length;
}

/** @param {View} view @param {number} body @returns {Point} */
function pointOf(view, body) {
  const [x, y] = view.poses[body];
  return [x, y];
}

/** Of the angle at `start` between `end` and `place`. @param {Point} start @param {Point} end @param {Point} place */
function cosine(start, end, place) {
  const [ax, ay, bx, by] = [end[0] - start[0], end[1] - start[1], place[0] - start[0], place[1] - start[1]];
  return (ax * bx + ay * by) / Math.max(Math.hypot(ax, ay) * Math.hypot(bx, by), 1e-9);
}

/** From a place to the nearest goal, straight. @param {GameMap} map @param {Point} place */
function goalGap(map, [x, y]) {
  const gaps = map.goals.map(({ x0, y0, x1, y1 }) =>
    Math.hypot(
      Math.max(Math.min(x0, x1) - x, 0, x - Math.max(x0, x1)),
      Math.max(Math.min(y0, y1) - y, 0, y - Math.max(y0, y1)),
    ),
  );
  return Math.min(...gaps);
}
