// The picture of the round: the canvas, and in which order world, decisions and pings are drawn on it.

import { byId } from "../../core/dom.js";
import { Painter } from "../../view/painter.js";
import { context2d, drawScene, fitCanvas, paintInMemory } from "../../view/render.js";

/** @typedef {import("../../view/render.js").Intent} Intent */

const PULSE_MS = 1200;
const calm = matchMedia("(prefers-reduced-motion: reduce)");

export class Arena {
  #canvas = byId("arena", HTMLCanvasElement);
  #context = context2d(this.#canvas);
  /** @type {Painter | null} of a page that draws slowly */
  #painter = null;
  #game;
  #cues;
  #pings;
  #decisions;

  /**
   * @param {import("../game.js").Game} game
   * @param {{cues: import("../signals/cues.js").Cues, pings: import("./pings.js").Pings,
   *   decisions: import("../decision_trace.js").DecisionPanel}} layers what is drawn over the world
   */
  constructor(game, { cues, pings, decisions }) {
    this.#game = game;
    this.#cues = cues;
    this.#pings = pings;
    this.#decisions = decisions;
  }

  /** For a page that draws slowly: from now on only what has changed is painted. */
  paintInMemory() {
    this.#canvas = paintInMemory(this.#canvas);
    this.#context = context2d(this.#canvas, true);
    this.#painter = new Painter(this.#context);
  }

  /**
   * Once per frame.
   * @param {import("../game.js").Scene} scene
   * @param {number} nowMs
   * @param {readonly (Intent | null)[]} stick where the stick of each seat of this page points
   */
  draw(scene, nowMs, stick) {
    const { round, own, phase } = this.#game;
    if (round === null) return;
    const { view } = scene;
    fitCanvas(this.#canvas);
    const pulse = calm.matches ? 1 : 0.5 + 0.5 * Math.sin((2 * Math.PI * nowMs) / PULSE_MS);
    const intents = phase === "playing" ? stick : [];
    this.#cues.update(scene, nowMs, pulse, calm.matches);
    const { reach, misses, over } = this.#cues;
    const ringed = own.length === 1 ? own : [];
    const options = { intents, own: ringed, pulse, rounded: true, reach, misses, over };
    const more = this.#cues.marks || this.#pings.shown.length > 0 || this.#decisions.isOn;
    if (this.#painter) this.#painter.paint(round.map, view, options, more);
    else drawScene(this.#context, round.map, view, options);
    if (phase === "playing") this.#decisions.draw(this.#context, round.map, view);
    this.#pings.draw(this.#context, nowMs, calm.matches);
  }
}
