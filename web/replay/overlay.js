// @ts-check
/*
 * What the replay can draw over the arena: the robots' recent paths, and the candidates that agents compared (GET
 * /api/recordings/{id}/thoughts). Knows which decision belongs to a tick, but not the page.
 */

import { currentTheme } from "../core/colours.js";
import { ArenaContext } from "../view/arena_context.js";
import { PING_TICKS, ROBOT_RADIUS, TICK_MS } from "../messages.js";
import { drawDecision } from "../view/candidates.js";
import { drawPing } from "../view/ping.js";

/** @typedef {import("./data.js").Replay} Replay */
/** @typedef {[number, number]} Point arena units */
/**
 * @typedef {object} DecisionTrace one decision
 * @property {number} seat
 * @property {number} tick the one that was decided about
 * @property {number} chosen index of the candidate that was played, -1 none
 * @property {number[]} scores per candidate
 * @property {Point[][]} ways per candidate: where it was to lead
 * @property {[Point, Point][]} moves items that the chosen one was to move: from, to
 * @property {[Point, Point][][]} robots per prediction of the partner and moment: where blue and red were expected
 * @property {Point[][]} guesses what was expected of the partner: where it was to lead
 */

export const TRAIL_TICKS = 50;
const SAME_PLACE = 0.02; // arena units: poses are rounded
const LASTS_TICKS = 15; // without a newer decision for this long, none is shown

/**
 * The newest decision of each seat at `tick`, unless it is too old.
 * @param {readonly DecisionTrace[]} decisions in order of ticks
 * @param {number} tick
 */
export function decisionsAt(decisions, tick) {
  return [0, 1]
    .map((seat) => decisions.findLast((decision) => decision.seat === seat && decision.tick <= Math.max(tick, 1)))
    .filter((decision) => decision !== undefined && tick - decision.tick <= LASTS_TICKS)
    .map((decision) => /** @type {DecisionTrace} */ (decision));
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Replay} replay
 * @param {number} timeMs
 * @param {number} stepMs between two points
 */
export function drawTrails(ctx, replay, timeMs, stepMs) {
  const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
  const points = Array.from({ length: TRAIL_TICKS + 1 }, (_, back) => timeMs - back * stepMs).filter((ms) => ms >= 0);
  const views = points.map((ms) => replay.viewAt(ms).poses);
  for (const [seat, colour] of [arena.theme.blue, arena.theme.red].entries()) {
    const way = views.map(({ [seat]: [x, y] }) => /** @type {Point} */ ([x, y]));
    for (const { from, to, age } of trail(way)) line(arena, [from, to], colour, 3, 1 - age / (TRAIL_TICKS + 1));
  }
}

/**
 * The pings that are shown at `timeMs`, with where the own place of each was.
 * @param {Replay} replay @param {number} timeMs
 * @returns {import("../view/ping.js").Ping[]}
 */
export function pingsAt(replay, timeMs) {
  const said = replay.summary.events.filter(({ kind, tick }) => {
    const age = timeMs / TICK_MS - (tick - 1);
    return kind === "ping" && age >= 0 && age < PING_TICKS;
  });
  return said.map(({ seat, item, tick }) => {
    const [x, y] = replay.viewAt((tick - 1) * TICK_MS).poses[seat];
    return { seat, item, x, y };
  });
}

/** @param {CanvasRenderingContext2D} ctx @param {Replay} replay @param {number} timeMs */
export function drawPings(ctx, replay, timeMs) {
  const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
  for (const ping of pingsAt(replay, timeMs)) drawPing(arena, replay.summary.map, replay.viewAt(timeMs), ping, 0.5);
}

/** The steps of a way, newest first, that the robot does not stand on. @param {readonly Point[]} way from now back */
export function trail(way) {
  const [x, y] = way[0];
  const steps = way.slice(1).map((to, index) => ({ from: way[index], to, age: index + 1 }));
  return steps.filter(({ from }) => Math.hypot(from[0] - x, from[1] - y) >= ROBOT_RADIUS);
}

/**
 * A decision as it is drawn and told. `view`: the instant in which it was made.
 * @param {DecisionTrace} trace @param {import("../view/render.js").View} view
 * @returns {import("../view/candidates.js").Decision}
 */
export function recordedDecision({ seat, tick, chosen, scores, ways, moves, robots, guesses }, view) {
  return {
    seat,
    tick,
    chosen,
    scores,
    ways,
    moves: moves.map(([from, place]) => ({ item: itemAt(view, from), place })).filter(({ item }) => item >= 0),
    own: robots.map((moments) => moments.map((places) => places[seat])),
    partner: robots.map((moments) => moments.map((places) => places[1 - seat])),
    guesses,
  };
}

/** The item at a place, -1 for none. @param {import("../view/render.js").View} view @param {Point} place */
function itemAt(view, [x, y]) {
  const gaps = view.poses.slice(2).map(([ix, iy]) => Math.hypot(ix - x, iy - y));
  const item = gaps.indexOf(Math.min(...gaps));
  return (gaps[item] ?? Infinity) < SAME_PLACE ? item : -1;
}

/** @param {CanvasRenderingContext2D} ctx @param {Replay} replay @param {readonly DecisionTrace[]} traces */
export function drawDecisions(ctx, replay, traces) {
  const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
  for (const trace of traces) {
    const view = replay.viewAt((trace.tick - 1) * TICK_MS);
    drawDecision(arena, replay.summary.map, view, recordedDecision(trace, view));
  }
}

/**
 * @param {ArenaContext} arena
 * @param {Point[]} points
 * @param {string} colour
 * @param {number} width hairs
 * @param {number} alpha
 * @param {number} [dash] pixels, 0 for a solid line
 */
function line(arena, points, colour, width, alpha, dash = 0) {
  const { ctx } = arena;
  ctx.save();
  ctx.beginPath();
  for (const point of points) ctx.lineTo(...arena.at(...point));
  Object.assign(ctx, { strokeStyle: colour, globalAlpha: alpha, lineWidth: width * arena.hair, lineJoin: "round" });
  if (dash > 0) ctx.setLineDash([dash, dash]);
  ctx.stroke();
  ctx.restore();
}
