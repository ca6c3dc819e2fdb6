// @ts-check
/*
 * How two computer players got on with the map: what they reached, and the trial as a film over the drawing.
 */

import { byId } from "../core/dom.js";
import { secondsOf } from "../core/ticks.js";
import { TICK_MS } from "../messages.js";
import { say, sayNumber } from "../text/catalogue.js";

/** @typedef {import("../view/render.js").View} View */
/**
 * @typedef {object} Solution as the server sends it
 * @property {boolean} solved
 * @property {number} ticks
 * @property {number} delivered
 * @property {number} items
 * @property {View[]} frames one per tick, from 0
 */

/** "All 3 items home in 23.4 s." @param {Solution} solution */
export function solutionText({ solved, ticks, delivered, items }) {
  const seconds = sayNumber(secondsOf(ticks), 1);
  if (solved) return say("editor.solved", { count: items, seconds });
  return say("editor.notSolved", { delivered, items, seconds });
}

export class Trial {
  /** @param {Solution} solution @param {(view: View) => void} show @param {() => void} closed */
  constructor(solution, show, closed) {
    this.frames = solution.frames;
    this.show = show;
    this.tick = 0;
    this.timer = 0;
    this.box = byId("trial", HTMLElement);
    this.line = byId("trial-line", HTMLInputElement);
    this.button = byId("trial-play", HTMLButtonElement);
    this.box.hidden = false;
    this.line.max = String(this.frames.length - 1);
    this.line.oninput = () => {
      this.stop();
      this.seek(this.line.valueAsNumber);
    };
    this.button.onclick = () => (this.timer ? this.stop() : this.play());
    byId("trial-close", HTMLButtonElement).onclick = closed;
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.stop();
    else this.play();
    this.seek(0);
  }

  play() {
    if (this.tick >= this.frames.length - 1) this.seek(0);
    this.timer = window.setInterval(() => {
      this.seek(this.tick + 1);
      if (this.tick >= this.frames.length - 1) this.stop();
    }, TICK_MS / 2); // twice as fast as it was
    this.button.textContent = say("editor.trial.pause");
  }

  stop() {
    window.clearInterval(this.timer);
    this.timer = 0;
    this.button.textContent = say("editor.trial.play");
  }

  /** @param {number} tick */
  seek(tick) {
    this.tick = Math.min(tick, this.frames.length - 1);
    this.line.value = String(this.tick);
    this.line.setAttribute("aria-valuetext", `${sayNumber(secondsOf(this.tick), 1)} s`);
    this.redraw();
  }

  redraw() {
    this.show(this.frames[this.tick]);
  }

  close() {
    this.stop();
    this.box.hidden = true;
  }
}
