// Draws an item of the arena: its shape, who holds it, whether it needs a second robot or is delivered.

import { readable } from "../core/colours.js";
import { outline } from "../shapes.js";

/** @typedef {import("./arena_context.js").ArenaContext} ArenaContext */
/** @typedef {import("./render.js").Item} Item */
/** @typedef {import("./render.js").Options} Options */
/** @typedef {import("./render.js").Triple} Triple */
/** @typedef {import("./render.js").View} View */

const MARKS = new Map([
  ["large", "2"],
  ["middle", "1–2"],
]);

/** @param {ArenaContext} arena @param {Item} item */
function tracePath(arena, item) {
  if (item.shape === "circle") return arena.circle(item.scale * arena.unit);
  arena.ctx.beginPath();
  for (const [x, y] of outline(item.shape, item.scale)) arena.ctx.lineTo(x * arena.unit, -y * arena.unit);
  arena.ctx.closePath();
}

/** @param {ArenaContext} arena @param {Item} item @param {View} view @param {number} index @param {Options} options */
export function drawItem(arena, item, view, index, options) {
  const { ctx, theme } = arena;
  const pose = view.poses[index + 2];
  const fill = theme[/** @type {"item-small"} */ (`item-${item.size}`)];
  const holders = [0, 1].filter((seat) => view.held[seat] === index);
  arena.around(pose, () => {
    ctx.lineJoin = "round";
    tracePath(arena, item);
    strokeReach(arena, index, options);
    ctx.fillStyle = fill;
    ctx.fill();
    strokeItem(arena, holders);
  });
  if (options.plain) return;
  const ink = readable(fill, "#ffffff", "#18212c");
  if (item.size === "large" && holders.length === 1)
    drawNeedsTwo(arena, pose, item, view.poses[holders[0]], 1 - holders[0], options.pulse ?? 1);
  arena.around([pose[0], pose[1], 0], () => {
    if (view.delivered[index]) drawTick(arena, ink);
    else arena.label(MARKS.get(item.size) ?? "", arena.letters(0.056), ink);
  });
}

/**
 * A wide outline in the colour of the seat that would take the item; half of it is covered by the item.
 * @param {ArenaContext} arena @param {number} index @param {Options} options
 */
function strokeReach({ ctx, theme, hair }, index, { reach }) {
  if (reach === undefined) return;
  if (reach[0] === index) ctx.strokeStyle = theme.blue;
  else if (reach[1] === index) ctx.strokeStyle = theme.red;
  else return;
  ctx.lineWidth = 10 * hair;
  ctx.stroke();
}

/**
 * The outline shows who holds an item: blue solid, red dashed, or both.
 * @param {ArenaContext} arena
 * @param {number[]} holders
 */
function strokeItem(arena, holders) {
  const { ctx, theme } = arena;
  ctx.strokeStyle = theme["item-edge"];
  ctx.lineWidth = 1.5 * arena.hair;
  ctx.stroke();
  for (const seat of holders) {
    ctx.strokeStyle = seat === 0 ? theme.blue : theme.red;
    ctx.lineWidth = 4 * arena.hair;
    ctx.setLineDash(seat === 0 ? [] : [0.03 * arena.unit, 0.03 * arena.unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  }
}

/**
 * A ring around a large item held by one robot, and on the free side an arc that pulses in the other's colour.
 * @param {ArenaContext} arena
 * @param {Triple} pose
 * @param {Item} item
 * @param {Triple} holder
 * @param {number} missing the seat that is to come
 * @param {number} pulse
 */
function drawNeedsTwo(arena, pose, item, holder, missing, pulse) {
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
    const free = Math.atan2(holder[1] - pose[1], pose[0] - holder[0]); // canvas angles run clockwise
    ctx.beginPath();
    ctx.arc(0, 0, radius, free - 0.6, free + 0.6);
    ctx.strokeStyle = missing === 0 ? theme.blue : theme.red;
    ctx.lineWidth = (5 + 4 * pulse) * arena.hair;
    ctx.stroke();
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
