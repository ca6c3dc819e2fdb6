// The decisions of agents, over the arena and beside it, for spectators who switch it on: the paths of all candidates,
// where the chosen one is expected to bring items and robots, what the partner is expected to do, and the scores. Asks
// the server only while it is on.

import { currentTheme } from "../core/colours.js";
import { el } from "../core/dom.js";
import { ArenaContext } from "../view/arena_context.js";
import { ROBOT_RADIUS } from "../view/robot.js";
import { outline } from "../shapes.js";
import { say, sayNumber } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

const STEP = 0.06; // arena units that a robot drives in a tick at full stick
const MOVED = 0.03; // arena units; an item expected to move less is not drawn
const STALE_MS = 1500; // of play; an older decision is not shown

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */
/** @typedef {import("../view/render.js").Triple} Triple */
/** @typedef {[number, number]} Point */
/**
 * @typedef {object} DecisionTrace  one decision
 * @property {number} seat
 * @property {number} tick
 * @property {number} chosen  index of the candidate that is played
 * @property {number[]} scores  per candidate
 * @property {[number, number, number][][]} candidates  per candidate and tick: distance, cos, sin of the heading
 * @property {Point[][]} items  per candidate: where it is expected to bring the items
 * @property {[number, number, number][][]} [guesses]  commands expected of the partner, as candidates
 * @property {[number, number][]} [pairs]  a candidate and a guess that were simulated together
 * @property {[Point, Point][][]} [robots]  per pair: where blue and red are expected on the way and in the end
 */

export class DecisionPanel {
  /** @type {EventSource | null} */
  #source = null;
  /** @type {Map<number, {decision: DecisionTrace, atMs: number}>} by seat */
  #newest = new Map();
  #shown = "";
  #writtenAtMs = performance.now();
  #button;
  #list = el("div");

  /** @param {HTMLElement} box @param {string} path of the event stream */
  constructor(box, path) {
    this.box = box;
    this.path = path;
    this.#button = el("button", { type: "button", class: "button button-wide", onclick: () => this.#toggle() });
  }

  /** Shows the switch, above the scores, so that a change of them does not move it under the pointer. */
  offer() {
    this.box.hidden = false;
    this.box.replaceChildren(
      el("h2", { id: "decisions-title" }, say("play.candidates.title")),
      this.#button,
      this.#list,
    );
    this.#label();
  }

  /** Draws over the scene. @param {CanvasRenderingContext2D} ctx @param {GameMap} map @param {View} view */
  draw(ctx, map, view) {
    const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
    for (const decision of this.#fresh()) drawDecision(arena, map, view, decision);
  }

  /** The scores, in words. Nothing gets stale in a pause. @param {boolean} paused */
  write(paused) {
    const nowMs = performance.now();
    if (paused) for (const newest of this.#newest.values()) newest.atMs += nowMs - this.#writtenAtMs;
    this.#writtenAtMs = nowMs;
    if (this.#source === null) return;
    const fresh = this.#fresh();
    const shown = fresh.map(({ seat, tick }) => `${seat}:${tick}`).join();
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#list.replaceChildren(
      ...(fresh.length > 0 ? fresh.map(scoreList) : [el("p", { class: "muted" }, say("play.candidates.none"))]),
    );
  }

  #toggle() {
    if (this.#source === null) this.#open();
    else this.#close();
    this.#label();
  }

  #open() {
    this.#source = new EventSource(this.path);
    this.#source.onmessage = ({ data }) => {
      const decision = /** @type {DecisionTrace} */ (JSON.parse(data));
      this.#newest.set(decision.seat, { decision, atMs: performance.now() });
    };
    this.#shown = "?";
  }

  #close() {
    this.#source?.close();
    this.#source = null;
    this.#newest.clear();
    this.#list.replaceChildren();
  }

  #label() {
    this.#button.textContent = this.#source === null ? say("play.candidates.show") : say("play.candidates.hide");
    this.#button.setAttribute("aria-pressed", String(this.#source !== null));
  }

  #fresh() {
    const since = performance.now() - STALE_MS;
    return [...this.#newest.values()].filter(({ atMs }) => atMs > since).map(({ decision }) => decision);
  }
}

/** The letter of a candidate. @param {number} index */
export function letterOf(index) {
  return String.fromCharCode(65 + index);
}

/**
 * The path of a candidate for an unhindered robot, its start included.
 * @param {readonly (readonly [number, number, number])[]} rows distance, cos, sin per tick @param {Triple} start
 * @returns {Point[]}
 */
export function wayOf(rows, [x, y]) {
  /** @type {Point[]} */
  const way = [[x, y]];
  for (const [distance, cos, sin] of rows) {
    const step = STEP * Math.max(-1, Math.min(1, distance));
    x -= step * sin;
    y += step * cos;
    way.push([x, y]);
  }
  return way;
}

/**
 * The items that the chosen candidate is expected to move.
 * @param {DecisionTrace} decision
 * @param {View} view
 * @returns {{item: number, place: Point}[]}
 */
export function movedItems(decision, view) {
  const places = decision.items[decision.chosen] ?? [];
  return places
    .map((place, item) => ({ item, place }))
    .filter(({ item, place: [x, y] }) => {
      const pose = view.poses[item + 2];
      return pose !== undefined && Math.hypot(x - pose[0], y - pose[1]) > MOVED;
    });
}

/**
 * Where both robots are expected if the chosen candidate is played, for each guess of the partner's.
 * @param {DecisionTrace} decision @returns {[Point, Point][][]} per guess and moment: blue, red
 */
export function expectedRobots({ chosen, pairs = [], robots = [] }) {
  return robots.filter((_, index) => pairs[index]?.[0] === chosen);
}

/** @param {DecisionTrace} decision */
function scoreList(decision) {
  const rows = decision.scores.map((score, index) => {
    const words = `${letterOf(index)}  ${sayNumber(score, 3)}`;
    return el(
      "li",
      {},
      index === decision.chosen ? el("strong", {}, `${words}  ${say("play.candidates.chosen")}`) : words,
    );
  });
  return el("div", {}, el("p", { class: "label" }, colourName(decision.seat)), el("ol", {}, ...rows));
}

/** @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {DecisionTrace} decision */
function drawDecision(arena, map, view, decision) {
  const now = /** @type {[Point, Point]} */ (view.poses.slice(0, 2).map(([x, y]) => [x, y]));
  const partner = 1 - decision.seat;
  for (const { item, place } of movedItems(decision, view)) drawExpected(arena, map, view, item, place);
  for (const rows of decision.guesses ?? []) drawGuess(arena, partner, wayOf(rows, view.poses[partner]));
  for (const moments of expectedRobots(decision)) drawRobots(arena, [now, ...moments]);
  const order = decision.candidates
    .map((_, index) => index)
    .sort((a, b) => Number(a === decision.chosen) - Number(b === decision.chosen));
  for (const index of order) drawWay(arena, view, decision, index);
}

/** @param {ArenaContext} arena @param {View} view @param {DecisionTrace} decision @param {number} index */
function drawWay(arena, view, decision, index) {
  const { ctx, theme } = arena;
  const chosen = index === decision.chosen;
  const way = wayOf(decision.candidates[index], view.poses[decision.seat]);
  ctx.beginPath();
  for (const point of way) ctx.lineTo(...arena.at(...point));
  ctx.strokeStyle = chosen ? theme.attention : theme.ink;
  ctx.globalAlpha = chosen ? 1 : 0.55;
  ctx.lineWidth = (chosen ? 4 : 1.5) * arena.hair;
  ctx.lineJoin = "round";
  ctx.stroke();
  const [x, y] = way[way.length - 1];
  arena.around([x, y, 0], () => arena.label(letterOf(index), 0.05 * arena.unit, theme.ink));
  ctx.globalAlpha = 1;
}

/** What the partner may do. @param {ArenaContext} arena @param {number} seat @param {Point[]} way */
export function drawGuess(arena, seat, way) {
  drawLine(arena, way, seatColour(arena, seat), 1.5, 0.02 * arena.unit);
}

/**
 * Both robots' expected paths, with a ring at the end.
 * @param {ArenaContext} arena
 * @param {[Point, Point][]} moments
 */
export function drawRobots(arena, moments) {
  for (const seat of [0, 1]) {
    const way = moments.map((places) => places[seat]);
    drawLine(arena, way, seatColour(arena, seat), 2.5);
    const [x, y] = way[way.length - 1];
    arena.around([x, y, 0], () => {
      arena.circle(ROBOT_RADIUS * arena.unit);
      stroke(arena, seatColour(arena, seat), 2, 0.03 * arena.unit);
    });
  }
}

/** @param {ArenaContext} arena @param {number} seat */
function seatColour({ theme }, seat) {
  return seat === 0 ? theme.blue : theme.red;
}

/**
 * @param {ArenaContext} arena
 * @param {Point[]} way
 * @param {string} colour
 * @param {number} width hairs
 * @param {number} [dash] pixels
 */
function drawLine(arena, way, colour, width, dash = 0) {
  arena.ctx.beginPath();
  for (const point of way) arena.ctx.lineTo(...arena.at(...point));
  stroke(arena, colour, width, dash);
}

/**
 * @param {ArenaContext} arena
 * @param {string} colour
 * @param {number} width hairs
 * @param {number} dash pixels, 0 for a solid line
 */
function stroke({ ctx, hair }, colour, width, dash) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width * hair;
  ctx.lineJoin = "round";
  ctx.setLineDash(dash > 0 ? [dash, dash] : []);
  ctx.stroke();
  ctx.setLineDash([]);
}

/** @param {ArenaContext} arena @param {GameMap} map @param {View} view @param {number} item @param {Point} place */
function drawExpected(arena, map, view, item, [x, y]) {
  const { ctx, theme, unit } = arena;
  const { shape, scale } = map.items[item];
  arena.around([x, y, view.poses[item + 2][2]], () => {
    if (shape === "circle") arena.circle(scale * unit);
    else {
      ctx.beginPath();
      for (const [px, py] of outline(shape, scale)) ctx.lineTo(px * unit, -py * unit);
      ctx.closePath();
    }
    ctx.strokeStyle = theme.attention;
    ctx.lineWidth = 2 * arena.hair;
    ctx.setLineDash([0.03 * unit, 0.02 * unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  });
}
