// Draws one instant of the world on a canvas: the same picture for the game, the replay and the map cards.
// A pure function of map, view and options; it knows no clock, no socket and no page.

import { currentTheme, readable } from "../core/colours.js";
import { staticLayer } from "./layer.js";
import { ArenaContext } from "./arena_context.js";
import { outline } from "../shapes.js";

export const ROBOT_RADIUS = 0.12;
const LETTERS = ["B", "R"];
const MARKS = new Map([
  ["large", "2"],
  ["middle", "1–2"],
]);

/** @typedef {import("../core/colours.js").Theme} Theme */
/** @typedef {{x0: number, y0: number, x1: number, y1: number}} Rect */
/**
 * @typedef {object} Item
 * @property {number} id
 * @property {string} shape
 * @property {string} size
 * @property {number} scale
 * @property {number} mass
 * @property {number} x
 * @property {number} y
 * @property {number} angle radians
 */
/** @typedef {{x: number, y: number, angle: number}} Pose */
/**
 * @typedef {object} GameMap  our map JSON
 * @property {string} name
 * @property {string} title
 * @property {number} number
 * @property {string} mode
 * @property {string} description
 * @property {{blue: Pose, red: Pose}} robots
 * @property {Rect[]} walls
 * @property {Rect[]} goals
 * @property {Item[]} items
 */
/** @typedef {readonly [number, number, number]} Triple  x, y [arena units], angle [rad] */
/**
 * @typedef {object} View  one instant
 * @property {readonly Triple[]} poses  the two robots, then the items in the map's order
 * @property {readonly number[]} held  index of the item that blue and red hold, -1 for none
 * @property {readonly boolean[]} delivered  per item
 */
/** @typedef {{x: number, y: number}} Intent  where the stick points: right and up are positive, length 0 to 1 */
/**
 * @typedef {object} Options
 * @property {Theme} [theme]  default: the page's
 * @property {boolean} [plain]  without letters and marks, for small pictures
 * @property {readonly (Intent | null)[]} [intents]  per seat: the arrow of a stick of this page
 * @property {readonly number[]} [own]  seats of this page, to be ringed
 * @property {number} [pulse]  0 to 1: phase of the cue "needs two"; constant without motion
 */

/** The view of a map before anything moved. @param {GameMap} map @returns {View} */
export function startView(map) {
  const bodies = [map.robots.blue, map.robots.red, ...map.items];
  return {
    poses: bodies.map(({ x, y, angle }) => /** @type {Triple} */ ([x, y, angle])),
    held: [-1, -1],
    delivered: map.items.map(() => false),
  };
}

/**
 * Sets the canvas' resolution to its size on the page.
 * @param {HTMLCanvasElement} canvas
 * @returns {boolean} whether it changed
 */
export function fitCanvas(canvas) {
  const side = Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio));
  if (canvas.width === side && canvas.height === side) return false;
  canvas.width = side;
  canvas.height = side;
  return true;
}

/** A small picture of a map at its start. @param {HTMLCanvasElement} canvas @param {GameMap} map */
export function mapPicture(canvas, map) {
  fitCanvas(canvas);
  drawScene(context2d(canvas), map, startView(map), { plain: canvas.clientWidth < 320 });
}

/** @param {HTMLCanvasElement} canvas @returns {CanvasRenderingContext2D} */
export function context2d(canvas) {
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("this browser cannot draw on a canvas");
  return context;
}

/**
 * Draws `view` over the whole canvas.
 * @param {CanvasRenderingContext2D} ctx @param {GameMap} map @param {View} view @param {Options} [options]
 */
export function drawScene(ctx, map, view, options = {}) {
  const arena = new ArenaContext(ctx, options.theme ?? currentTheme(), ctx.canvas.width);
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  ctx.drawImage(staticLayer(ctx.canvas, map, arena.theme), 0, 0);
  const order = map.items.map((_, index) => index).sort((a, b) => Number(isHeld(view, a)) - Number(isHeld(view, b)));
  for (const index of order) drawItem(arena, map.items[index], view, index, options);
  for (const seat of [0, 1]) drawGrip(arena, view, seat);
  for (const seat of [0, 1]) drawRobot(arena, view.poses[seat], seat, options);
}

/** @param {View} view @param {number} item */
function isHeld(view, item) {
  return view.held[0] === item || view.held[1] === item;
}

// ---- what moves --------------------------------------------------------------------------------------------

/** @param {ArenaContext} arena @param {Item} item */
function tracePath(arena, item) {
  if (item.shape === "circle") return arena.circle(item.scale * arena.unit);
  arena.ctx.beginPath();
  for (const [x, y] of outline(item.shape, item.scale)) arena.ctx.lineTo(x * arena.unit, -y * arena.unit);
  arena.ctx.closePath();
}

/** @param {ArenaContext} arena @param {Item} item @param {View} view @param {number} index @param {Options} options */
function drawItem(arena, item, view, index, options) {
  const { ctx, theme } = arena;
  const pose = view.poses[index + 2];
  const fill = theme[/** @type {"item-small"} */ (`item-${item.size}`)];
  const holders = [0, 1].filter((seat) => view.held[seat] === index);
  arena.around(pose, () => {
    ctx.lineJoin = "round";
    tracePath(arena, item);
    ctx.fillStyle = fill;
    ctx.fill();
    strokeItem(arena, holders);
  });
  if (options.plain) return;
  const ink = readable(fill, "#ffffff", "#18212c");
  if (item.size === "large" && holders.length === 1) drawNeedsTwo(arena, pose, item, options.pulse ?? 1);
  arena.around([pose[0], pose[1], 0], () => {
    if (view.delivered[index]) drawTick(arena, ink);
    else arena.label(MARKS.get(item.size) ?? "", 0.056 * arena.unit, ink);
  });
}

/**
 * The outline shows who holds an item: blue solid, red dashed, or both.
 * @param {ArenaContext} arena
 * @param {number[]} holders
 */
function strokeItem(arena, holders) {
  const { ctx, theme } = arena;
  ctx.strokeStyle = theme.ink;
  ctx.globalAlpha = 0.42;
  ctx.lineWidth = 1.5 * arena.hair;
  ctx.stroke();
  ctx.globalAlpha = 1;
  for (const seat of holders) {
    ctx.strokeStyle = seat === 0 ? theme.blue : theme.red;
    ctx.lineWidth = 4 * arena.hair;
    ctx.setLineDash(seat === 0 ? [] : [0.03 * arena.unit, 0.03 * arena.unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  }
}

/**
 * A ring around a large item held by one robot, which needs the other.
 * @param {ArenaContext} arena
 * @param {Triple} pose
 * @param {Item} item
 * @param {number} pulse
 */
function drawNeedsTwo(arena, pose, item, pulse) {
  const { ctx, theme } = arena;
  const corners = outline(item.shape, item.scale).map(([x, y]) => Math.hypot(x, y));
  const radius = (Math.max(item.scale, ...corners) + 0.035 + 0.02 * pulse) * arena.unit;
  arena.around([pose[0], pose[1], 0], () => {
    arena.circle(radius);
    ctx.strokeStyle = theme.attention;
    ctx.lineWidth = 3 * arena.hair;
    ctx.setLineDash([0.05 * arena.unit, 0.03 * arena.unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  });
}

/** @param {ArenaContext} arena @param {string} colour */
function drawTick(arena, colour) {
  const { ctx, unit } = arena;
  ctx.beginPath();
  ctx.moveTo(-0.022 * unit, 0.001 * unit);
  ctx.lineTo(-0.006 * unit, 0.017 * unit);
  ctx.lineTo(0.024 * unit, -0.016 * unit);
  ctx.strokeStyle = colour;
  ctx.lineWidth = 2.2 * arena.hair;
  ctx.lineCap = "round";
  ctx.stroke();
  ctx.lineCap = "butt";
}

/**
 * A short bar from a robot to the item it holds, drawn under the robot.
 * @param {ArenaContext} arena
 * @param {View} view
 * @param {number} seat
 */
function drawGrip(arena, view, seat) {
  const held = view.held[seat];
  if (held < 0) return;
  const { ctx, theme } = arena;
  const [from, to] = [view.poses[seat], view.poses[held + 2]];
  ctx.beginPath();
  ctx.moveTo(...arena.at(from[0], from[1]));
  ctx.lineTo(...arena.at(from[0] + 0.7 * (to[0] - from[0]), from[1] + 0.7 * (to[1] - from[1])));
  ctx.strokeStyle = seat === 0 ? theme.blue : theme.red;
  ctx.lineWidth = 0.035 * arena.unit;
  ctx.lineCap = "round";
  ctx.stroke();
  ctx.lineCap = "butt";
}

/** @param {ArenaContext} arena @param {Triple} pose @param {number} seat @param {Options} options */
function drawRobot(arena, pose, seat, options) {
  const { ctx, theme } = arena;
  const radius = ROBOT_RADIUS * arena.unit;
  const colour = seat === 0 ? theme.blue : theme.red;
  const ink = readable(colour, "#ffffff", "#18212c");
  const intent = options.intents?.[seat];
  if (intent) drawIntent(arena, pose, colour, intent);
  if (options.own?.includes(seat)) drawOwnRing(arena, pose, colour);
  arena.around(pose, () => {
    arena.circle(radius);
    ctx.fillStyle = colour;
    ctx.fill();
    drawRing(arena, seat, ink);
    drawNotch(arena, ink);
  });
  if (options.plain) return;
  arena.around([pose[0], pose[1], 0], () => arena.label(LETTERS[seat], 0.064 * arena.unit, ink));
}

/**
 * Blue solid, red dashed: colour is never the only cue.
 * @param {ArenaContext} arena
 * @param {number} seat
 * @param {string} ink
 */
function drawRing(arena, seat, ink) {
  const { ctx, unit } = arena;
  arena.circle((ROBOT_RADIUS - 0.013) * unit);
  ctx.strokeStyle = ink;
  ctx.globalAlpha = 0.75;
  ctx.lineWidth = Math.max(0.009 * unit, arena.hair);
  if (seat === 1) ctx.setLineDash([0.028 * unit, 0.0282 * unit]);
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

/** The notch points where the robot faces. @param {ArenaContext} arena @param {string} ink */
function drawNotch(arena, ink) {
  const { ctx, unit } = arena;
  ctx.beginPath();
  ctx.moveTo(0, -0.116 * unit);
  ctx.lineTo(0.034 * unit, -0.068 * unit);
  ctx.lineTo(-0.034 * unit, -0.068 * unit);
  ctx.closePath();
  ctx.fillStyle = ink;
  ctx.fill();
}

/** @param {ArenaContext} arena @param {Triple} pose @param {string} colour */
function drawOwnRing(arena, pose, colour) {
  arena.around(pose, () => {
    arena.circle((ROBOT_RADIUS + 0.02) * arena.unit);
    arena.ctx.strokeStyle = colour;
    arena.ctx.globalAlpha = 0.45;
    arena.ctx.lineWidth = 2.5 * arena.hair;
    arena.ctx.stroke();
  });
}

/**
 * The direction of the reader's own stick, drawn in the same frame, before the server responds.
 * @param {ArenaContext} arena
 * @param {Triple} pose
 * @param {string} colour
 * @param {Intent} intent
 */
function drawIntent(arena, pose, colour, intent) {
  const strength = Math.min(1, Math.hypot(intent.x, intent.y));
  if (strength === 0) return;
  const { ctx, unit } = arena;
  arena.around([pose[0], pose[1], Math.atan2(-intent.x, intent.y)], () => {
    const tip = -(ROBOT_RADIUS + 0.05 + 0.06 * strength) * unit;
    const foot = -(ROBOT_RADIUS + 0.03) * unit;
    const wing = 0.032 * unit;
    ctx.beginPath();
    ctx.moveTo(-wing, Math.min(foot, tip + wing));
    ctx.lineTo(0, tip);
    ctx.lineTo(wing, Math.min(foot, tip + wing));
    ctx.strokeStyle = colour;
    ctx.lineWidth = 0.02 * unit;
    ctx.lineCap = "round";
    ctx.lineJoin = "round";
    ctx.stroke();
  });
}
