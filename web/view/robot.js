// Draws a robot of the arena: its body, its grip on an item, and the direction of the reader's own stick.

import { readable } from "../core/colours.js";
import { ROBOT_RADIUS } from "../messages.js";

/** @typedef {import("./arena_context.js").ArenaContext} ArenaContext */
/** @typedef {import("./render.js").Intent} Intent */
/** @typedef {import("./render.js").Options} Options */
/** @typedef {import("./render.js").Triple} Triple */
/** @typedef {import("./render.js").View} View */

const LETTERS = ["B", "R"];

/**
 * A short bar from a robot to the item it holds, drawn under the robot.
 * @param {ArenaContext} arena
 * @param {View} view
 * @param {number} seat
 */
export function drawGrip(arena, view, seat) {
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
export function drawRobot(arena, pose, seat, options) {
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
    drawNotch(arena, ink, options.misses?.[seat] ?? 0);
  });
  if (options.plain) return;
  arena.around([pose[0], pose[1], 0], () => arena.label(LETTERS[seat], arena.letters(0.064), ink));
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

/**
 * The notch points where the robot faces; a grab that missed moves it aside.
 * @param {ArenaContext} arena @param {string} ink @param {number} aside -1 to 1
 */
function drawNotch(arena, ink, aside) {
  const { ctx, unit } = arena;
  ctx.rotate(0.35 * aside);
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
    arena.ctx.lineWidth = 2 * arena.hair;
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
