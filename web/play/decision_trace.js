// What agents weigh, over the arena and beside it, for spectators who switch it on: the ways of all candidates, where
// the chosen one is expected to bring items and robots, what the partner is expected to do, and the scores. Asks the
// server only while it is on.

import { currentTheme } from "../core/colours.js";
import { el } from "../core/dom.js";
import { Pen } from "../view/pen.js";
import { ROBOT_RADIUS } from "../view/render.js";
import { outline } from "../shapes.js";
import { say, sayNumber } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

const STEP = 0.06; // arena units that a robot drives in a tick at full stick
const MOVED = 0.03; // arena units; an item expected to move less is not drawn
const STALE_MS = 1500; // of play; an agent that has said nothing for so long is not shown

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */
/** @typedef {import("../view/render.js").Triple} Triple */
/** @typedef {[number, number]} Point */
/**
 * @typedef {object} Thought  one decision
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

export class Thoughts {
  /** @type {EventSource | null} */
  #source = null;
  /** @type {Map<number, {thought: Thought, atMs: number}>} by seat */
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

  /** Shows the switch, above the scores: what comes and goes must not move it away under the pointer. */
  offer() {
    this.box.hidden = false;
    this.box.replaceChildren(
      el("h2", { id: "thoughts-title" }, say("play.candidates.title")),
      this.#button,
      this.#list,
    );
    this.#label();
  }

  /** Draws over the scene. @param {CanvasRenderingContext2D} ctx @param {GameMap} map @param {View} view */
  draw(ctx, map, view) {
    const pen = new Pen(ctx, currentTheme(), ctx.canvas.width);
    for (const thought of this.#fresh()) drawThought(pen, map, view, thought);
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
      const thought = /** @type {Thought} */ (JSON.parse(data));
      this.#newest.set(thought.seat, { thought, atMs: performance.now() });
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
    return [...this.#newest.values()].filter(({ atMs }) => atMs > since).map(({ thought }) => thought);
  }
}

/** The letter of a candidate. @param {number} index */
export function letterOf(index) {
  return String.fromCharCode(65 + index);
}

/**
 * The way of a candidate for a robot that nothing hinders, its start included.
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
 * @param {Thought} thought
 * @param {View} view
 * @returns {{item: number, place: Point}[]}
 */
export function movedItems(thought, view) {
  const places = thought.items[thought.chosen] ?? [];
  return places
    .map((place, item) => ({ item, place }))
    .filter(({ item, place: [x, y] }) => {
      const pose = view.poses[item + 2];
      return pose !== undefined && Math.hypot(x - pose[0], y - pose[1]) > MOVED;
    });
}

/**
 * Where both robots are expected if the chosen candidate is played, for each guess of the partner's.
 * @param {Thought} thought @returns {[Point, Point][][]} per guess and moment: blue, red
 */
export function expectedRobots({ chosen, pairs = [], robots = [] }) {
  return robots.filter((_, index) => pairs[index]?.[0] === chosen);
}

/** @param {Thought} thought */
function scoreList(thought) {
  const rows = thought.scores.map((score, index) => {
    const words = `${letterOf(index)}  ${sayNumber(score, 3)}`;
    return el(
      "li",
      {},
      index === thought.chosen ? el("strong", {}, `${words}  ${say("play.candidates.chosen")}`) : words,
    );
  });
  return el("div", {}, el("p", { class: "label" }, colourName(thought.seat)), el("ol", {}, ...rows));
}

/** @param {Pen} pen @param {GameMap} map @param {View} view @param {Thought} thought */
function drawThought(pen, map, view, thought) {
  const now = /** @type {[Point, Point]} */ (view.poses.slice(0, 2).map(([x, y]) => [x, y]));
  const partner = 1 - thought.seat;
  for (const { item, place } of movedItems(thought, view)) drawExpected(pen, map, view, item, place);
  for (const rows of thought.guesses ?? []) drawGuess(pen, partner, wayOf(rows, view.poses[partner]));
  for (const moments of expectedRobots(thought)) drawRobots(pen, [now, ...moments]);
  const order = thought.candidates
    .map((_, index) => index)
    .sort((a, b) => Number(a === thought.chosen) - Number(b === thought.chosen));
  for (const index of order) drawWay(pen, view, thought, index);
}

/** @param {Pen} pen @param {View} view @param {Thought} thought @param {number} index */
function drawWay(pen, view, thought, index) {
  const { ctx, theme } = pen;
  const chosen = index === thought.chosen;
  const way = wayOf(thought.candidates[index], view.poses[thought.seat]);
  ctx.beginPath();
  for (const point of way) ctx.lineTo(...pen.at(...point));
  ctx.strokeStyle = chosen ? theme.attention : theme.ink;
  ctx.globalAlpha = chosen ? 1 : 0.55;
  ctx.lineWidth = (chosen ? 4 : 1.5) * pen.hair;
  ctx.lineJoin = "round";
  ctx.stroke();
  const [x, y] = way[way.length - 1];
  pen.around([x, y, 0], () => pen.label(letterOf(index), 0.05 * pen.unit, theme.ink));
  ctx.globalAlpha = 1;
}

/** What the partner may do. @param {Pen} pen @param {number} seat @param {Point[]} way */
export function drawGuess(pen, seat, way) {
  drawLine(pen, way, seatColour(pen, seat), 1.5, 0.02 * pen.unit);
}

/**
 * Both robots from moment to moment, a ring where they are expected in the end.
 * @param {Pen} pen
 * @param {[Point, Point][]} moments
 */
export function drawRobots(pen, moments) {
  for (const seat of [0, 1]) {
    const way = moments.map((places) => places[seat]);
    drawLine(pen, way, seatColour(pen, seat), 2.5);
    const [x, y] = way[way.length - 1];
    pen.around([x, y, 0], () => {
      pen.circle(ROBOT_RADIUS * pen.unit);
      stroke(pen, seatColour(pen, seat), 2, 0.03 * pen.unit);
    });
  }
}

/** @param {Pen} pen @param {number} seat */
function seatColour({ theme }, seat) {
  return seat === 0 ? theme.blue : theme.red;
}

/**
 * @param {Pen} pen
 * @param {Point[]} way
 * @param {string} colour
 * @param {number} width hairs
 * @param {number} [dash] pixels
 */
function drawLine(pen, way, colour, width, dash = 0) {
  pen.ctx.beginPath();
  for (const point of way) pen.ctx.lineTo(...pen.at(...point));
  stroke(pen, colour, width, dash);
}

/**
 * @param {Pen} pen
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

/** @param {Pen} pen @param {GameMap} map @param {View} view @param {number} item @param {Point} place */
function drawExpected(pen, map, view, item, [x, y]) {
  const { ctx, theme, unit } = pen;
  const { shape, scale } = map.items[item];
  pen.around([x, y, view.poses[item + 2][2]], () => {
    if (shape === "circle") pen.circle(scale * unit);
    else {
      ctx.beginPath();
      for (const [px, py] of outline(shape, scale)) ctx.lineTo(px * unit, -py * unit);
      ctx.closePath();
    }
    ctx.strokeStyle = theme.attention;
    ctx.lineWidth = 2 * pen.hair;
    ctx.setLineDash([0.03 * unit, 0.02 * unit]);
    ctx.stroke();
    ctx.setLineDash([]);
  });
}
