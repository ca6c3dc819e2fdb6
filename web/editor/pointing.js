// @ts-check
/*
 * What a pointer means on the drawing: which part or handle is under it, and what a drag makes of the map. Knows
 * neither page nor history.
 */

import { addItem, addRect, isRect, middle, movedBy, movedTo, partsOf, reach, reshaped, sides } from "./parts.js";
import { scaled, snapped, thing, turnedTo, STEP, TURN } from "./parts.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */
/** @typedef {import("./parts.js").Point} Point */
/** @typedef {import("./parts.js").Rect} Rect */
/** @typedef {Point & {name: "corner" | "turn" | "size", opposite?: Point}} Handle */
/** @typedef {{tool: "select" | "wall" | "goal" | "item", shape: string, size: string, snap: boolean}} Settings */
/**
 * A drag or click in progress: what the map becomes when the pointer is at `to`, and which part is then selected.
 * @typedef {(to: Point) => {map: GameMap, selected: Part | null}} Gesture
 */

const TURN_REACH = 0.14; // from the edge of an item or robot to the handle that turns it
const SIZE_REACH = 0.04; // to the one that makes an item larger
const DEFAULT_SIDES = { wall: [0.6, 0.1], goal: [0.6, 0.4] };

/** The handles of a selected part. @param {GameMap} map @param {Part} part @returns {Handle[]} */
export function handlesOf(map, part) {
  const it = thing(map, part);
  if ("x0" in it) {
    const { left, bottom, right, top } = sides(it);
    return [left, right].flatMap((x) =>
      [bottom, top].map((y) => ({
        name: /** @type {const} */ ("corner"),
        x,
        y,
        opposite: { x: left + right - x, y: bottom + top - y },
      })),
    );
  }
  const far = reach(map, part);
  const [beyond, aside] = [far + TURN_REACH, far + SIZE_REACH];
  const turn = {
    name: /** @type {const} */ ("turn"),
    x: it.x - beyond * Math.sin(it.angle),
    y: it.y + beyond * Math.cos(it.angle),
  };
  if (part.kind === "robots") return [turn];
  return [turn, { name: "size", x: it.x + aside * Math.cos(it.angle), y: it.y + aside * Math.sin(it.angle) }];
}

/**
 * The topmost part at a place; small ones are found from a little beside them.
 * @param {GameMap} map @param {Point} at @param {number} near
 */
export function partUnder(map, at, near) {
  const found = partsOf(map).filter((part) => {
    const it = thing(map, part);
    if (!("x0" in it)) return Math.hypot(at.x - it.x, at.y - it.y) <= Math.max(reach(map, part), near);
    const { left, bottom, right, top } = sides(it);
    return at.x >= left - near / 4 && at.x <= right + near / 4 && at.y >= bottom - near / 4 && at.y <= top + near / 4;
  });
  const order = ["robots", "items", "walls", "goals"];
  return found.sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind) || b.index - a.index)[0] ?? null;
}

/**
 * What begins when the pointer goes down; null where nothing is.
 * @param {GameMap} map @param {Part | null} selected @param {Point} at @param {Settings} settings @param {number} near
 * @returns {Gesture | null}
 */
export function gestureAt(map, selected, at, settings, near) {
  const { tool, snap } = settings;
  const onGrid = (/** @type {Point} */ { x, y }) => ({
    x: snapped(x, snap ? STEP : 0),
    y: snapped(y, snap ? STEP : 0),
  });
  if (tool === "item") return (to) => withNew(map, addItem(map, settings.shape, settings.size, onGrid(to)), "items");
  if (tool !== "select") return (to) => drawnRect(map, tool, onGrid(at), onGrid(to));
  const handle = selected && handleUnder(map, selected, at, near);
  if (selected && handle) return (to) => ({ map: handled(map, selected, handle, to, snap), selected });
  const part = partUnder(map, at, near);
  if (part === null) return null;
  const from = middle(map, part);
  const corner = isRect(part) ? sides(/** @type {Rect} */ (thing(map, part))) : { left: from.x, bottom: from.y };
  return (to) => {
    if (Math.hypot(to.x - at.x, to.y - at.y) < near / 6) return { map, selected: part };
    const place = onGrid({ x: corner.left + to.x - at.x, y: corner.bottom + to.y - at.y });
    return { map: movedBy(map, part, place.x - corner.left, place.y - corner.bottom), selected: part };
  };
}

/**
 * The nearest handle, unless the middle of the part is nearer: what is small can still be moved.
 * @param {GameMap} map @param {Part} part @param {Point} at @param {number} near
 */
function handleUnder(map, part, at, near) {
  const away = (/** @type {Point} */ { x, y }) => Math.hypot(x - at.x, y - at.y);
  const [nearest] = handlesOf(map, part).sort((a, b) => away(a) - away(b));
  return away(nearest) <= near && away(nearest) < away(middle(map, part)) ? nearest : null;
}

/** What a tool adds without a pointer. @param {GameMap} map @param {Settings} settings @param {Point} at */
export function added(map, settings, at) {
  if (settings.tool === "item") return withNew(map, addItem(map, settings.shape, settings.size, at), "items");
  return drawnRect(map, settings.tool === "goal" ? "goal" : "wall", at, at);
}

/**
 * @param {GameMap} map
 * @param {"wall" | "goal"} tool
 * @param {Point} from
 * @param {Point} to a click gives the usual size
 */
function drawnRect(map, tool, from, to) {
  const kind = tool === "wall" ? "walls" : "goals";
  const [width, height] = DEFAULT_SIDES[tool];
  const click = Math.hypot(to.x - from.x, to.y - from.y) < STEP / 2;
  const more = click
    ? addRect(map, kind, { x: -width / 2, y: -height / 2 }, { x: width / 2, y: height / 2 })
    : addRect(map, kind, from, to);
  const made = withNew(map, more, kind);
  return click && made.selected ? { ...made, map: movedTo(made.map, made.selected, from) } : made;
}

/** @param {GameMap} before @param {GameMap} map @param {"walls" | "goals" | "items"} kind */
function withNew(before, map, kind) {
  return { map, selected: map === before ? null : { kind, index: map[kind].length - 1 } };
}

/**
 * @param {GameMap} map
 * @param {Part} part
 * @param {Handle} handle
 * @param {Point} to
 * @param {boolean} snap
 * @returns {GameMap}
 */
function handled(map, part, handle, to, snap) {
  const step = snap ? STEP : 0;
  if (handle.name === "corner" && handle.opposite)
    return reshaped(map, part, handle.opposite, { x: snapped(to.x, step), y: snapped(to.y, step) });
  const { x, y } = middle(map, part);
  if (handle.name === "turn") return turnedTo(map, part, snapped(Math.atan2(x - to.x, to.y - y), snap ? TURN : 0));
  const now = thing(map, part);
  const wanted = (Math.hypot(to.x - x, to.y - y) - SIZE_REACH) / reach(map, part);
  return "scale" in now ? scaled(map, part, now.scale * wanted) : map;
}
