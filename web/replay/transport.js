// @ts-check
/*
 * The arena and the time line below it: draws a replay, plays and pauses it, moves by ticks, changes the speed. The
 * elements are those of replay.html.
 */

import { byId, el } from "../core/dom.js";
import { actionFor } from "../core/shortcuts.js";
import { ticksOf } from "../core/ticks.js";
import { TICK_MS } from "../messages.js";
import { say } from "../text/catalogue.js";
import { context2d, drawScene, fitCanvas } from "../view/render.js";
import { tickAt } from "./data.js";
import { tickTime } from "./event_words.js";
import { Player, SPEEDS } from "./player.js";

/** @typedef {import("./data.js").Replay} Replay */
/** @typedef {import("../view/render.js").View} View */
/** @typedef {Record<string, () => void>} Keys what to do by the name of the key */

const PLAY_ICON = "M6 3.5v13l11-6.5z";
const PAUSE_ICON = "M5 3.5h4v13H5zM11 3.5h4v13h-4z";
const SECOND = ticksOf(1);
const LONGEST_FRAME_MS = 250; // a tab that was hidden does not jump ahead

export class Transport {
  #canvas = byId("arena", HTMLCanvasElement);
  #line = byId("line", HTMLInputElement);
  #speed = byId("speed", HTMLSelectElement);
  #play = byId("play", HTMLButtonElement);
  #frame = 0;
  #lastMs = 0;
  /** @type {Replay | null} */
  #replay = null;

  /**
   * @param {(context: CanvasRenderingContext2D, view: View, tick: number) => void} onDraw after every picture
   * @param {() => void} onMove after every change of the position or of playing
   */
  constructor(onDraw, onMove = () => {}) {
    this.onDraw = onDraw;
    this.onMove = onMove;
    this.player = new Player(0, TICK_MS);
    this.#speed.replaceChildren(
      ...SPEEDS.map((speed) => el("option", { value: speed }, say("replay.speed.times", { speed }))),
    );
    this.#speed.value = "1";
  }

  /** Shows another replay, from its start and at the speed chosen before. @param {Replay} replay */
  open(replay) {
    const { speed } = this.player;
    this.#replay = replay;
    this.player = new Player(replay.durationMs, TICK_MS);
    this.player.speed = speed;
    this.#line.max = String(replay.ticks);
  }

  get tick() {
    return tickAt(this.player.timeMs);
  }

  /**
   * Listens to the buttons, to the keys of every replay and to those of the page, which do one thing per press.
   * @param {Keys} keys
   */
  listen(keys) {
    this.#play.addEventListener("click", () => this.toggle());
    byId("back", HTMLElement).addEventListener("click", () => this.step(-1));
    byId("forward", HTMLElement).addEventListener("click", () => this.step(1));
    this.#line.addEventListener("input", () => this.seekTick(this.#line.valueAsNumber));
    this.#speed.addEventListener("change", () => (this.player.speed = Number(this.#speed.value)));
    document.addEventListener("keydown", (event) => this.#press(event, keys));
    new ResizeObserver(() => this.refresh()).observe(this.#canvas);
    window.addEventListener("movingout-theme", () => this.refresh());
  }

  toggle() {
    this.player.toggle();
    this.refresh();
  }

  /** @param {number} ticks */
  step(ticks) {
    this.player.step(ticks);
    this.refresh();
  }

  /** @param {number} tick */
  seekTick(tick) {
    this.player.seek(tick * TICK_MS);
    this.refresh();
  }

  /** @param {-1 | 1} direction */
  changeSpeed(direction) {
    this.player.changeSpeed(direction);
    this.#speed.value = String(this.player.speed);
  }

  /** Draws the current instant, and keeps drawing while playing. */
  refresh() {
    if (this.player.playing && this.#frame === 0) {
      this.#lastMs = performance.now();
      this.#frame = requestAnimationFrame((now) => this.#animate(now));
    }
    this.onMove();
    this.#draw();
  }

  /** @param {KeyboardEvent} event @param {Keys} ofPage */
  #press(event, ofPage) {
    const { target } = event;
    const writes =
      target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && target.type === "text");
    if (event.ctrlKey || event.metaKey || event.altKey || writes) return;
    const onButton = target instanceof Element && target.closest("button, a, summary, input[type=checkbox]") !== null;
    const far = event.shiftKey ? SECOND : 1;
    /** @type {Keys} */
    const keys = {
      ArrowLeft: () => this.step(-far),
      ArrowRight: () => this.step(far),
      "-": () => this.changeSpeed(-1),
      "+": () => this.changeSpeed(1),
      "=": () => this.changeSpeed(1),
      Home: () => this.seekTick(0),
      End: () => this.seekTick(this.#replay?.ticks ?? 0),
      ...(onButton ? {} : { " ": () => this.toggle() }),
      ...ofPage,
    };
    const action = actionFor(keys, event);
    if (!action) return;
    event.preventDefault();
    if (!event.repeat || !Object.values(ofPage).includes(action)) action();
  }

  /** @param {number} now */
  #animate(now) {
    this.#frame = 0;
    this.player.advance(Math.min(now - this.#lastMs, LONGEST_FRAME_MS));
    this.#lastMs = now;
    if (this.player.playing) this.#frame = requestAnimationFrame((next) => this.#animate(next));
    else this.onMove();
    this.#draw();
  }

  #draw() {
    const replay = this.#replay;
    if (replay === null) return;
    const view = replay.viewAt(this.player.timeMs);
    fitCanvas(this.#canvas);
    drawScene(context2d(this.#canvas), replay.summary.map, view, { rounded: true });
    this.#drawLine(replay);
    this.onDraw(context2d(this.#canvas), view, this.tick);
    this.#play.setAttribute("aria-label", say(this.player.playing ? "replay.pause" : "replay.play"));
    document.getElementById("play-icon")?.setAttribute("d", this.player.playing ? PAUSE_ICON : PLAY_ICON);
  }

  /** @param {Replay} replay */
  #drawLine({ ticks }) {
    const { tick } = this;
    this.#line.valueAsNumber = tick;
    this.#line.setAttribute("aria-valuetext", say("replay.timeOf", { time: tickTime(tick), all: tickTime(ticks) }));
    this.#line.style.setProperty("--done", `${(100 * tick) / Math.max(ticks, 1)}%`);
    byId("time", HTMLElement).textContent = tickTime(tick);
    byId("tick", HTMLElement).textContent = say("replay.tickOf", { tick, ticks });
  }
}
