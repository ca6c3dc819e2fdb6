// @ts-check
/*
 * What the reader can show over the arena: recent paths, and the candidates of agents with their scores. Decisions are
 * fetched when first shown.
 */

import { byId, el, notice } from "../core/dom.js";
import { TICK_MS } from "../messages.js";
import { tickAt } from "./data.js";
import { drawDecisions, drawPings, drawTrails, ranking, decisionsAt } from "./overlay.js";
import { say, sayError, sayNumber } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

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
    drawDecisions(ctx, shown);
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
    this.#words.replaceChildren(...none, ...shown.map(scores));
  }
}

/** @param {DecisionTrace} decision */
function scores(decision) {
  const best = ranking(decision).slice(0, 4);
  const words = best.map(({ letter, score, chosen }) =>
    el(chosen ? "strong" : "span", {}, `${letter} ${sayNumber(score, 2)}`),
  );
  const values = { colour: colourName(decision.seat), tick: decision.tick, count: decision.ways.length };
  const decided = values.count === 1 ? say("replay.decision", values) : say("replay.bestOf", values);
  return el("p", { class: "replay-scores" }, decided, ...words);
}
