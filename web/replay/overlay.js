// @ts-check
/*
 * What the replay can draw over the arena: the robots' recent paths, and the candidates that agents compared (GET
 * /api/recordings/{id}/thoughts). Knows which decision belongs to a tick, but not the page.
 */

import { currentTheme } from "../core/colours.js";
import { ArenaContext } from "../view/arena_context.js";
import { PING_TICKS, TICK_MS } from "../messages.js";
import { drawPing } from "../view/ping.js";
import { ROBOT_RADIUS } from "../view/robot.js";
import { drawGuess, drawRobots, letterOf } from "../play/decision_trace.js";

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

/** Candidates from the best score to the worst, with letter and score. @param {DecisionTrace} decision */
export function ranking({ scores, chosen }) {
  return scores
    .map((score, index) => ({ letter: letterOf(index), score, chosen: index === chosen }))
    .sort((a, b) => b.score - a.score);
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

/** @param {CanvasRenderingContext2D} ctx @param {readonly DecisionTrace[]} decisions */
export function drawDecisions(ctx, decisions) {
  const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
  const { theme } = arena;
  for (const { seat, ways, chosen, moves, robots, guesses } of decisions) {
    for (const way of guesses) drawGuess(arena, 1 - seat, way);
    for (const moments of robots) drawRobots(arena, moments);
    const order = ways.map((_, index) => index).sort((a, b) => Number(a === chosen) - Number(b === chosen));
    for (const index of order) {
      const played = index === chosen;
      line(arena, ways[index], played ? theme.attention : theme.ink, played ? 4 : 1.5, played ? 1 : 0.55);
      const [x, y] = ways[index][ways[index].length - 1];
      if (ways.length > 1) arena.around([x, y, 0], () => arena.label(letterOf(index), 0.05 * arena.unit, theme.ink));
    }
    for (const move of moves) line(arena, move, theme.attention, 2, 1, 0.02 * arena.unit);
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
