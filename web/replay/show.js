// @ts-check
/*
 * What the reader can show over the arena: recent paths, and the candidates of agents with their scores. Decisions are
 * fetched when first shown.
 */

import { byId, el, notice } from "../core/dom.js";
import { TICK_MS } from "../messages.js";
import { tickAt } from "./data.js";
import { decisionsAt, drawDecisions, drawPings, drawTrails, recordedDecision } from "./overlay.js";
import { say, sayError } from "../text/catalogue.js";
import { decisionLegend, decisionList } from "../view/decision_words.js";
import { planOf } from "../view/plan.js";

/** @typedef {import("./data.js").Replay} Replay */
/** @typedef {import("./overlay.js").DecisionTrace} DecisionTrace */

export class Show {
  /** @type {DecisionTrace[]} */
  #decisions = [];
  #asked = false;
  #written = "";
  #trailsBox = byId("trails", HTMLInputElement);
  #candidatesBox = byId("decisions", HTMLInputElement);
  #words = byId("weighed", HTMLElement);

  /**
   * @param {Replay} replay
   * @param {() => Promise<DecisionTrace[]>} load
   * @param {() => void} onChange
   */
  constructor(replay, load, onChange) {
    this.replay = replay;
    this.load = load;
    this.onChange = onChange;
    byId("candidates-choice", HTMLElement).hidden = !replay.summary.has_thoughts;
    this.#trailsBox.addEventListener("change", onChange);
    this.#candidatesBox.addEventListener("change", () => void this.#changed());
  }

  /** What the keys T and A do. @param {"trails" | "decisions"} which */
  toggle(which) {
    const box = which === "trails" ? this.#trailsBox : this.#candidatesBox;
    if (which === "trails" || this.replay.summary.has_thoughts) box.click();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {number} timeMs */
  draw(ctx, timeMs) {
    if (this.#trailsBox.checked) drawTrails(ctx, this.replay, timeMs, TICK_MS);
    const shown = this.#candidatesBox.checked ? decisionsAt(this.#decisions, tickAt(timeMs)) : [];
    drawDecisions(ctx, this.replay, shown);
    drawPings(ctx, this.replay, timeMs);
    this.#write(shown);
  }

  async #changed() {
    if (this.#candidatesBox.checked && !this.#asked) {
      this.#asked = true;
      try {
        this.#decisions = await this.load();
      } catch (error) {
        this.#asked = this.#candidatesBox.checked = false;
        this.#words.replaceChildren(notice("bad", sayError(error)));
        return;
      }
    }
    this.#written = "?";
    this.onChange();
  }

  /** @param {DecisionTrace[]} shown */
  #write(shown) {
    const written = shown.map(({ seat, tick }) => `${seat}:${tick}`).join();
    if (written === this.#written) return;
    this.#written = written;
    const none =
      this.#candidatesBox.checked && shown.length === 0
        ? [el("p", { class: "muted" }, say("replay.nothingWeighed"))]
        : [];
    const legend = shown.length > 0 ? [decisionLegend()] : [];
    this.#words.replaceChildren(...none, ...shown.map((trace) => this.#told(trace)), ...legend);
  }

  /** @param {DecisionTrace} trace */
  #told(trace) {
    const view = this.replay.viewAt((trace.tick - 1) * TICK_MS);
    const decision = recordedDecision(trace, view);
    return decisionList(decision, planOf(this.replay.summary.map, view, decision), this.replay.summary.map);
  }
}
