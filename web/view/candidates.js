// Draws a decision of an agent over the arena: a path per candidate with its rank at the end, and for the chosen one
// alone where it is expected to bring items and robots. Nothing is written on robots.

import { ARENA_HALF, ROBOT_RADIUS } from "../messages.js";
import { outline } from "../shapes.js";

/** @typedef {import("./arena_context.js").ArenaContext} ArenaContext */
/** @typedef {import("./render.js").GameMap} GameMap */
/** @typedef {import("./render.js").View} View */
/** @typedef {[number, number]} Point  arena units */
/**
 * @typedef {object} Decision  one decision, wherever it comes from
 * @property {number} seat
 * @property {number} tick
 * @property {number} chosen  index of the candidate that is played, -1 none
 * @property {number[]} scores  per candidate, higher is better
 * @property {Point[][]} ways  per candidate: where it leads
 * @property {{item: number, place: Point}[]} moves  where the chosen one is expected to bring items
 * @property {Point[][]} own  where it is expected to bring the own robot: per prediction of the partner, over time
 * @property {Point[][]} partner  the same of the partner's robot
 * @property {Point[][]} guesses  where the partner is expected to go
 */

const BADGE = 0.05; // radius of a rank, arena units
const CLEAR = ROBOT_RADIUS + 0.03; // of a robot's centre, where nothing is drawn
const SHIFTS = [0, 0.11, 0.17, 0.24, 0.32, 0.4, 0.5]; // arena units that a rank may stand beside the end of its path

/** The rank of each candidate, 1 for the highest score. @param {readonly number[]} scores */
export function ranksOf(scores) {
  return scores.map(
    (score, index) => 1 + scores.filter((one, at) => one > score || (one === score && at < index)).length,
  );
}

/** @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {Decision} decision */
export function drawDecision(arena, map, view, decision) {
  const { chosen, seat, ways, guesses, own, partner, moves, scores } = decision;
  const colours = [arena.theme.blue, arena.theme.red];
  const robots = view.poses.slice(0, 2).map(([x, y]) => /** @type {Point} */ ([x, y]));
  for (const { item, place } of moves) drawItemGhost(arena, map, view, item, place);
  for (const way of [...guesses, ...partner]) line(arena, clipped(way, robots), colours[1 - seat], 2, 0.9, 0.02);
  drawRobotGhost(arena, own[0]?.at(-1), robots, colours[seat]);
  drawRobotGhost(arena, partner[0]?.at(-1), robots, colours[1 - seat]);
  const order = ways.map((_, index) => index).sort((a, b) => Number(a === chosen) - Number(b === chosen));
  for (const index of order) {
    const played = index === chosen;
    line(
      arena,
      clipped(ways[index], robots),
      played ? arena.theme.attention : arena.theme.ink,
      played ? 4 : 1.5,
      played ? 1 : 0.6,
    );
  }
  const ranks = ranksOf(scores);
  if (ways.length < 2) return;
  const places = badgePlaces(ways, ranks, robots);
  for (const index of order) {
    const end = clipped(ways[index], robots).at(-1) ?? places[index]; // no line to what is hidden by a robot
    drawRank(arena, places[index], end, ranks[index], index === chosen);
  }
}

/**
 * Where the ranks stand: at the ends of the paths, or near them where another rank or a robot is in the way.
 * @param {readonly Point[][]} ways @param {readonly number[]} ranks @param {readonly Point[]} robots @returns {Point[]}
 */
export function badgePlaces(ways, ranks, robots) {
  /** @type {Point[]} */
  const places = [];
  const taken = robots.map((centre) => ({ centre, radius: CLEAR }));
  const order = ways.map((_, index) => index).sort((a, b) => ranks[a] - ranks[b]);
  for (const index of order) {
    const end = ways[index].at(-1) ?? robots[0];
    const free = around(end).find((place) =>
      taken.every(({ centre, radius }) => distance(place, centre) >= radius + BADGE + 0.005),
    );
    places[index] = free ?? end;
    taken.push({ centre: places[index], radius: BADGE });
  }
  return places;
}

/** The place itself, then places around it, nearest first, within the arena. @param {Point} place @returns {Point[]} */
function around([x, y]) {
  const within = ARENA_HALF - BADGE;
  return SHIFTS.flatMap((shift) =>
    Array.from({ length: shift === 0 ? 1 : 12 }, (_, turn) => {
      const angle = (2 * Math.PI * turn) / 12;
      return /** @type {Point} */ (
        [x + shift * Math.cos(angle), y + shift * Math.sin(angle)].map((one) =>
          Math.max(-within, Math.min(within, one)),
        )
      );
    }),
  );
}

/** @param {Point} one @param {Point} other */
export function distance(one, other) {
  return Math.hypot(one[0] - other[0], one[1] - other[1]);
}

/** The part of a path outside of the robots. @param {readonly Point[]} way @param {readonly Point[]} robots */
function clipped(way, robots) {
  return way.filter((point) => robots.every((robot) => distance(point, robot) >= CLEAR));
}

/** @param {ArenaContext} arena @param {Point} place @param {Point} end @param {number} rank @param {boolean} chosen */
function drawRank(arena, place, end, rank, chosen) {
  const { ctx, theme, unit, hair } = arena;
  if (distance(place, end) > BADGE) line(arena, [end, place], theme["ink-2"], 1, 1);
  arena.around([...place, 0], () => {
    arena.circle(BADGE * unit);
    ctx.fillStyle = chosen ? theme.attention : theme.surface;
    ctx.fill();
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = 1.5 * hair;
    ctx.stroke();
    arena.label(String(rank), 0.07 * unit, chosen ? theme.surface : theme.ink);
  });
}

/**
 * A dashed ring where a robot is expected, unless it hardly moves.
 * @param {ArenaContext} arena @param {Point | undefined} place @param {readonly Point[]} robots @param {string} colour
 */
function drawRobotGhost(arena, place, robots, colour) {
  if (place === undefined || robots.some((robot) => distance(place, robot) < 2 * ROBOT_RADIUS)) return;
  const { ctx, unit, hair } = arena;
  arena.around([...place, 0], () => {
    arena.circle(ROBOT_RADIUS * unit);
    ctx.strokeStyle = colour;
    ctx.lineWidth = 2.5 * hair;
    ctx.setLineDash([0.04 * unit, 0.03 * unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  });
}

/** @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {number} item @param {Point} place */
function drawItemGhost(arena, map, view, item, place) {
  const { ctx, theme, unit, hair } = arena;
  const { shape, scale } = map.items[item];
  arena.around([...place, view.poses[item + 2][2]], () => {
    if (shape === "circle") arena.circle(scale * unit);
    else {
      ctx.beginPath();
      for (const [x, y] of outline(shape, scale)) ctx.lineTo(x * unit, -y * unit);
      ctx.closePath();
    }
    ctx.strokeStyle = theme.attention;
    ctx.lineWidth = 2 * hair;
    ctx.setLineDash([0.03 * unit, 0.02 * unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  });
}

/**
 * @param {ArenaContext} arena @param {readonly Point[]} points @param {string} colour @param {number} width hairs
 * @param {number} alpha @param {number} [dash] arena units, 0 for a solid line
 */
function line(arena, points, colour, width, alpha, dash = 0) {
  const { ctx, unit, hair } = arena;
  ctx.save();
  ctx.beginPath();
  for (const point of points) ctx.lineTo(...arena.at(...point));
  Object.assign(ctx, { strokeStyle: colour, globalAlpha: alpha, lineWidth: width * hair, lineJoin: "round" });
  if (dash > 0) ctx.setLineDash([dash * unit, dash * unit]);
  ctx.stroke();
  ctx.restore();
}
