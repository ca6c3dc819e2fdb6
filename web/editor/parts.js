// @ts-check
/*
 * A map and what can be done to it: every function takes a map and gives a new one. Knows no page and no history.
 * Lengths are arena units, y up; angles are radians, 0 looks along +y, counter-clockwise.
 */

import { textHash } from "../core/text_hash.js";
import { ARENA_HALF, ROBOT_RADIUS } from "../messages.js";
import { radiusOf } from "../shapes.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").Rect} Rect */
/** @typedef {import("../view/render.js").Item} Item */
/** @typedef {import("../view/render.js").Pose} Pose */
/** @typedef {"walls" | "goals"} RectKind */
/** @typedef {{kind: "walls" | "goals" | "items" | "robots", index: number}} Part robots: 0 blue, 1 red */
/** @typedef {{x: number, y: number}} Point */

export const SHAPES = ["circle", "square", "triangle", "pentagon", "hexagon", "octagon", "star", "rectangle"];
/** What the designed maps give to each size: the radius, and the mass. @type {Record<string, [number, number]>} */
export const SIZES = { small: [0.06, 0.1], middle: [0.11, 0.5], large: [0.17, 0.5] };
export const COLOURS = /** @type {const} */ (["blue", "red"]);
export const MOST = { walls: 64, goals: 64, items: 7 };
export const STEP = 0.05; // of the grid
export const TURN = Math.PI / 12;
const LONGEST_NAME = 40;
/** What tells titles apart and is in no name: letters, digits, pictures, flags, arrows; not "°" or "–". */
const LOST =
  /(?!\p{ASCII})[\p{L}\p{N}\p{Extended_Pictographic}\p{RI}\u2190-\u21ff\u27f0-\u27ff\u2900-\u297f\u2b00-\u2bff]/u;
const LEAST_SIDE = 0.02;
const LEAST_SCALE = 0.03;
const MOST_SCALE = 0.4;

/** A room to begin with: both robots, one goal, one item. @param {string} title @returns {GameMap} */
export function emptyMap(title) {
  const map = {
    format: 1,
    name: nameOf(title),
    title,
    number: 0,
    mode: "practice",
    description: "",
    robots: { blue: { x: -0.6, y: -0.9, angle: 0 }, red: { x: 0.6, y: -0.9, angle: 0 } },
    walls: [],
    goals: [{ x0: -0.4, y0: ARENA_HALF, x1: 0.4, y1: 0.7 }],
    items: [],
  };
  return addItem(map, "circle", "small", { x: 0, y: 0 });
}

/**
 * The name that a title makes: "Die große Garage" -> "DieGrosseGarage". Of a title with letters, pictures or arrows
 * that no name has, "Карта Маши", the name ends in a sign of the title: other titles make other names.
 * @param {string} title
 */
export function nameOf(title) {
  const plain = title.replace(/ß/g, "ss").normalize("NFKD").replace(/\p{M}/gu, "");
  const words = plain.split(/[^A-Za-z0-9]+/).filter((word) => word !== "");
  const name = words.map((word) => word[0].toUpperCase() + word.slice(1)).join("");
  const sign = LOST.test(plain) ? `-${textHash(title.normalize().trim())}` : "";
  return (/^[A-Za-z]/.test(name) ? name : `Map${name}`).slice(0, LONGEST_NAME - sign.length) + sign;
}

/** @param {GameMap} map @param {Part} part @returns {Rect | Item | Pose} */
export function thing(map, { kind, index }) {
  return kind === "robots" ? map.robots[COLOURS[index]] : map[kind][index];
}

/** Whether the part is there. @param {GameMap} map @param {Part} part */
export function exists(map, part) {
  return thing(map, part) !== undefined;
}

/** Every part, in the order of the document. @param {GameMap} map @returns {Part[]} */
export function partsOf(map) {
  const listed = /** @type {const} */ (["items", "walls", "goals"]).flatMap((kind) =>
    map[kind].map((_, index) => ({ kind, index })),
  );
  return [{ kind: "robots", index: 0 }, { kind: "robots", index: 1 }, ...listed];
}

/** "items[1]", "robots.red": where a part stands in the document. @param {Part} part */
export function pathOf({ kind, index }) {
  return kind === "robots" ? `robots.${COLOURS[index]}` : `${kind}[${index}]`;
}

/** The part that a path leads to; null for another path. @param {string} path @returns {Part | null} */
export function partAt(path) {
  const robot = /^robots\.(blue|red)/.exec(path);
  if (robot) return { kind: "robots", index: robot[1] === "blue" ? 0 : 1 };
  const listed = /^(walls|goals|items)\[(\d+)\]/.exec(path);
  return listed ? { kind: /** @type {"walls"} */ (listed[1]), index: Number(listed[2]) } : null;
}

/** @param {Part} part @returns {part is {kind: RectKind, index: number}} */
export function isRect(part) {
  return part.kind === "walls" || part.kind === "goals";
}

/** @param {number} value @param {number} step 0 for none */
export function snapped(value, step) {
  return rounded(step > 0 ? Math.round(value / step) * step : value);
}

/** No more digits than anybody sees, and no negative zero. @param {number} value */
function rounded(value) {
  return Math.round(value * 1000) / 1000 + 0;
}

/** @param {number} value */
function inside(value) {
  return rounded(Math.min(ARENA_HALF, Math.max(-ARENA_HALF, value)));
}

/** @param {Rect} rect as left, bottom, right, top */
export function sides({ x0, y0, x1, y1 }) {
  return { left: Math.min(x0, x1), bottom: Math.min(y0, y1), right: Math.max(x0, x1), top: Math.max(y0, y1) };
}

/** @param {GameMap} map @param {Part} part @returns {Point} its middle */
export function middle(map, part) {
  const it = thing(map, part);
  if ("x0" in it) return { x: (it.x0 + it.x1) / 2, y: (it.y0 + it.y1) / 2 };
  return { x: it.x, y: it.y };
}

/** How far from its middle an item or robot reaches. @param {GameMap} map @param {Part} part */
export function reach(map, part) {
  const it = thing(map, part);
  return "shape" in it ? radiusOf(it.shape, it.scale) : ROBOT_RADIUS;
}

/** @param {GameMap} map @param {Part} part @param {object} changes of its fields @returns {GameMap} */
export function changed(map, part, changes) {
  const now = { ...thing(map, part), ...changes };
  if (part.kind === "robots") return { ...map, robots: { ...map.robots, [COLOURS[part.index]]: now } };
  return { ...map, [part.kind]: map[part.kind].map((it, index) => (index === part.index ? now : it)) };
}

/** @param {GameMap} map @param {RectKind} kind @param {Point} from @param {Point} to opposite corners */
export function addRect(map, kind, from, to) {
  if (map[kind].length >= MOST[kind]) return map;
  return { ...map, [kind]: [...map[kind], corners(from, to)] };
}

/** @param {Point} from @param {Point} to @returns {Rect} never without area, never outside */
function corners(from, to) {
  const [x0, y0] = [inside(from.x), inside(from.y)];
  return { x0, y0, x1: apart(x0, inside(to.x)), y1: apart(y0, inside(to.y)) };
}

/** @param {number} fixed @param {number} moving */
function apart(fixed, moving) {
  if (Math.abs(moving - fixed) >= LEAST_SIDE) return moving;
  return inside(moving < fixed || fixed + LEAST_SIDE > ARENA_HALF ? fixed - LEAST_SIDE : fixed + LEAST_SIDE);
}

/** @param {GameMap} map @param {string} shape @param {string} size @param {Point} at @returns {GameMap} */
export function addItem(map, shape, size, at) {
  if (map.items.length >= MOST.items) return map;
  const id = Math.max(-1, ...map.items.map((item) => item.id)) + 1;
  const [scale, mass] = SIZES[size];
  return {
    ...map,
    items: [...map.items, { id, shape, size, scale, mass, x: inside(at.x), y: inside(at.y), angle: 0 }],
  };
}

/**
 * The size, with the radius and mass that belong to it.
 * @param {GameMap} map @param {Part} part @param {string} size
 */
export function resized(map, part, size) {
  const [scale, mass] = SIZES[size];
  return changed(map, part, { size, scale, mass });
}

/** @param {GameMap} map @param {Part} part @param {number} scale */
export function scaled(map, part, scale) {
  return changed(map, part, { scale: rounded(Math.min(MOST_SCALE, Math.max(LEAST_SCALE, scale))) });
}

/**
 * A part with its middle there, or as near as the arena lets it.
 * @param {GameMap} map @param {Part} part @param {Point} to
 */
export function movedTo(map, part, to) {
  const it = thing(map, part);
  if (!("x0" in it)) return changed(map, part, { x: inside(to.x), y: inside(to.y) });
  const { left, bottom, right, top } = sides(it);
  const dx = within(to.x - (left + right) / 2, -ARENA_HALF - left, ARENA_HALF - right);
  const dy = within(to.y - (bottom + top) / 2, -ARENA_HALF - bottom, ARENA_HALF - top);
  return changed(map, part, {
    x0: inside(it.x0 + dx),
    y0: inside(it.y0 + dy),
    x1: inside(it.x1 + dx),
    y1: inside(it.y1 + dy),
  });
}

/** @param {number} value @param {number} least @param {number} most */
function within(value, least, most) {
  return Math.min(most, Math.max(least, value));
}

/** @param {GameMap} map @param {Part} part @param {number} dx @param {number} dy */
export function movedBy(map, part, dx, dy) {
  const { x, y } = middle(map, part);
  return movedTo(map, part, { x: x + dx, y: y + dy });
}

/**
 * A wall or goal between two corners.
 * @param {GameMap} map @param {Part} part @param {Point} from @param {Point} to
 */
export function reshaped(map, part, from, to) {
  return changed(map, part, corners(from, to));
}

/** @param {GameMap} map @param {Part} part @param {number} angle */
export function turnedTo(map, part, angle) {
  if (isRect(part)) return quarterTurned(map, part);
  return changed(map, part, { angle: rounded(Math.atan2(Math.sin(angle), Math.cos(angle))) });
}

/** Width and height exchanged: rectangles of a map stand upright. @param {GameMap} map @param {Part} part */
function quarterTurned(map, part) {
  const { x, y } = middle(map, part);
  const { left, bottom, right, top } = sides(/** @type {Rect} */ (thing(map, part)));
  const [across, up] = [(top - bottom) / 2, (right - left) / 2];
  return movedTo(reshaped(map, part, { x: -across, y: -up }, { x: across, y: up }), part, { x, y });
}

/** Robots stay. @param {GameMap} map @param {Part} part @returns {GameMap} */
export function removed(map, part) {
  if (part.kind === "robots") return map;
  return { ...map, [part.kind]: map[part.kind].filter((_, index) => index !== part.index) };
}

/** A copy beside it, at the end of its list. @param {GameMap} map @param {Part} part @returns {GameMap} */
export function duplicated(map, { kind, index }) {
  if (kind === "robots" || map[kind].length >= MOST[kind]) return map;
  const id = Math.max(-1, ...map.items.map((item) => item.id)) + 1;
  const copy = { ...map[kind][index], ...(kind === "items" && { id }) };
  const more = { ...map, [kind]: [...map[kind], copy] };
  const last = { kind, index: map[kind].length };
  const { x, y } = middle(more, last);
  if (kind === "items")
    return movedBy(more, last, Math.ceil((2 * reach(more, last)) / STEP) * (x > 0 ? -STEP : STEP), 0);
  return movedBy(more, last, x > 0 ? -2 * STEP : 2 * STEP, y > 0 ? -2 * STEP : 2 * STEP);
}
