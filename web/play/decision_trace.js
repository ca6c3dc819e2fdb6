// The decisions of agents, over the arena and beside it, for spectators who switch it on: what an agent is trying, the
// scores of its candidates, their paths with ranks. Offered once an agent has weighed anything; asks for decisions only
// while it is on.

import { ApiError, requestJson } from "../core/api.js";
import { currentTheme } from "../core/colours.js";
import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { ArenaContext } from "../view/arena_context.js";
import { drawDecision } from "../view/candidates.js";
import { decisionLegend, decisionList, toldPlan } from "../view/decision_words.js";
import { planOf } from "../view/plan.js";

const STEP = 0.06; // arena units that a robot drives in a tick at full stick
const MOVED = 0.03; // arena units; an item expected to move less is not drawn
const STALE_MS = 1500; // of play; an older decision is not shown
const ASK_MS = 2000; // between two questions whether an agent here weighs candidates

/** @typedef {import("../view/candidates.js").Decision} Decision */
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

/** @typedef {{seat: number, tick: number, plan: string}} ToldPlan  what an agent says that it does */

export class DecisionPanel {
  /** @type {EventSource | null} */
  #source = null;
  /** @type {Map<number, {decision: DecisionTrace, atMs: number}>} by seat */
  #newest = new Map();
  /** @type {Map<number, {told: ToldPlan, atMs: number}>} by seat */
  #plans = new Map();
  #shown = "";
  #writtenAtMs = performance.now();
  /** @type {{map: GameMap, view: View} | null} what is shown */
  #scene = null;
  #button;
  // focusable, so that keys scroll it where it has little room
  #list = el("div", { class: "decision-lists", role: "group", tabindex: "0", "aria-labelledby": "decisions-title" });

  /** @param {HTMLElement} box @param {string} room  its API, /api/rooms/ROOM */
  constructor(box, room) {
    this.box = box;
    this.room = room;
    this.#button = el("button", { type: "button", class: "button button-wide", onclick: () => this.#toggle() });
  }

  /** Offers to look into the agents as soon as one of them has weighed candidates. */
  async offerWhenWeighing() {
    const answer = document.hidden ? "no" : await askWhetherWeighing(this.room);
    if (answer === "yes") this.#offer();
    if (answer === "no") setTimeout(() => void this.offerWhenWeighing(), ASK_MS);
  }

  /** Shows the switch, above the scores, so that a change of them does not move it under the pointer. */
  #offer() {
    this.box.hidden = false;
    this.box.replaceChildren(
      el("h2", { id: "decisions-title" }, say("play.candidates.title")),
      this.#button,
      this.#list,
    );
    this.#label();
  }

  /** Whether it draws over the scene. */
  get isOn() {
    return this.#source !== null;
  }

  /** Draws over the scene. @param {CanvasRenderingContext2D} ctx @param {GameMap} map @param {View} view */
  draw(ctx, map, view) {
    this.#scene = { map, view };
    const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
    for (const trace of this.#fresh()) drawDecision(arena, map, view, liveDecision(trace, view));
  }

  /** The scores, in words. Nothing gets stale in a pause. @param {boolean} paused */
  write(paused) {
    const nowMs = performance.now();
    if (paused)
      for (const newest of [...this.#newest.values(), ...this.#plans.values()])
        newest.atMs += nowMs - this.#writtenAtMs;
    this.#writtenAtMs = nowMs;
    if (this.#source === null) return;
    const scene = this.#scene;
    const fresh = scene === null ? [] : this.#fresh();
    const plans = this.#freshPlans();
    const shown = [
      ...fresh.map(({ seat, tick }) => `${seat}:${tick}`),
      ...plans.map(({ seat, plan }) => `${seat}:${plan}`),
    ].join();
    if (shown === this.#shown) return;
    this.#shown = shown;
    if (fresh.length + plans.length === 0 || scene === null)
      return this.#list.replaceChildren(el("p", { class: "muted" }, say("play.candidates.none")));
    const lists = fresh.map((trace) => {
      const decision = liveDecision(trace, scene.view);
      return decisionList(decision, planOf(scene.map, scene.view, decision), scene.map);
    });
    const legend = lists.length > 0 ? [decisionLegend()] : [];
    this.#list.replaceChildren(...plans.map(toldPlan), ...lists, ...legend);
  }

  #toggle() {
    if (this.#source === null) this.#open();
    else this.#close();
    this.#label();
  }

  #open() {
    this.#source = new EventSource(`${this.room}/thoughts`);
    this.#source.onmessage = ({ data }) => {
      const decision = /** @type {DecisionTrace | ToldPlan} */ (JSON.parse(data));
      const atMs = performance.now();
      if ("candidates" in decision) this.#newest.set(decision.seat, { decision, atMs });
      else this.#plans.set(decision.seat, { told: decision, atMs });
    };
    this.#shown = "?";
  }

  #close() {
    this.#source?.close();
    this.#source = null;
    this.#newest.clear();
    this.#plans.clear();
    this.#list.replaceChildren();
  }

  #label() {
    this.#button.textContent = this.#source === null ? say("play.candidates.show") : say("play.candidates.hide");
    this.#button.setAttribute("aria-pressed", String(this.#source !== null));
  }

  #freshPlans() {
    const since = performance.now() - STALE_MS;
    return [...this.#plans.values()].filter(({ atMs }) => atMs > since).map(({ told }) => told);
  }

  #fresh() {
    const since = performance.now() - STALE_MS;
    return [...this.#newest.values()].filter(({ atMs }) => atMs > since).map(({ decision }) => decision);
  }
}

/** @param {string} room  its API @returns {Promise<"yes" | "no" | "gone">} no: not yet, or nobody answers */
async function askWhetherWeighing(room) {
  try {
    return (await requestJson(room)).weighs ? "yes" : "no";
  } catch (error) {
    return error instanceof ApiError && error.status === 404 ? "gone" : "no";
  }
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

/**
 * A decision as it is drawn and told, with paths from where the robots are shown.
 * @param {DecisionTrace} trace @param {View} view @returns {Decision}
 */
export function liveDecision(trace, view) {
  const { seat, tick, chosen, scores, candidates, guesses = [] } = trace;
  const expected = expectedRobots(trace);
  return {
    seat,
    tick,
    chosen,
    scores,
    ways: candidates.map((rows) => wayOf(rows, view.poses[seat])),
    moves: movedItems(trace, view),
    own: expected.map((moments) => moments.map((places) => places[seat])),
    partner: expected.map((moments) => moments.map((places) => places[1 - seat])),
    guesses: guesses.map((rows) => wayOf(rows, view.poses[1 - seat])),
  };
}
