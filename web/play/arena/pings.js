// Pings on the game page: a key, a button or a tap says "help here"; the marker that both see for two seconds.

import { currentTheme } from "../../core/colours.js";
import { onPress } from "../../input/press.js";
import { TICK_MS } from "../../messages.js";
import { say } from "../../text/catalogue.js";
import { colourName } from "../../text/names.js";
import { ArenaContext } from "../../view/arena_context.js";
import { drawPing } from "../../view/ping.js";
import { arenaPoint, itemAhead, itemAt } from "../../view/ping_target.js";

/** @typedef {import("../game.js").Game} Game */
/** @typedef {import("../../messages.js").ShownPing} ShownPing */
/** @typedef {import("../../view/render.js").GameMap} GameMap */
/** @typedef {import("../../view/render.js").View} View */

const PULSE_MS = 700;

export class Pings {
  /** @type {{ping: ShownPing, untilMs: number}[]} */
  #shown = [];
  /** @type {View | null} */
  #view = null;
  #button;

  /**
   * @param {Game} game
   * @param {{send(message: import("../../messages.js").SayPing): void, announce(sentence: string): void}} actions
   * @param {{box: HTMLElement, button: HTMLButtonElement}} parts  the box has the canvas, which may be replaced
   */
  constructor(game, actions, { box, button }) {
    this.game = game;
    this.actions = actions;
    this.#button = button;
    button.setAttribute("aria-label", say("play.touch.ping"));
    onPress(button, { press: () => this.ask(game.own[0]) });
    box.addEventListener("pointerdown", (event) => {
      if (event.target instanceof HTMLCanvasElement) this.#tapped(event.target, event);
    });
  }

  /** Whether people of this page may ping in this room. */
  get possible() {
    return this.game.welcome?.pings === true && this.game.own.length > 0;
  }

  /** The seat asks for help with what is in front of it, or at its own place. @param {number} seat */
  ask(seat) {
    const map = this.game.round?.map;
    if (map && this.#view !== null) this.#send(seat, itemAhead(map, this.#view, seat));
  }

  /** @param {ShownPing} ping @param {number} nowMs */
  receive(ping, nowMs) {
    const { round, own } = this.game;
    if (round === null || ping.epoch !== round.epoch) return;
    this.#shown.push({ ping, untilMs: nowMs + ping.ticks * TICK_MS });
    if (!own.includes(ping.seat)) this.actions.announce(sentence(ping, round.map));
  }

  /** @param {View} view  the instant that is shown @param {number} nowMs */
  update(view, nowMs) {
    this.#view = view;
    this.#shown = this.#shown.filter(({ untilMs }) => untilMs > nowMs);
    this.#button.hidden = !this.possible;
  }

  /** Draws over the scene. @param {CanvasRenderingContext2D} ctx @param {number} nowMs @param {boolean} calm */
  draw(ctx, nowMs, calm) {
    const map = this.game.round?.map;
    if (!map || this.#view === null || this.#shown.length === 0) return;
    const arena = new ArenaContext(ctx, currentTheme(), ctx.canvas.width);
    const pulse = calm ? 0.5 : 0.5 + 0.5 * Math.sin((2 * Math.PI * nowMs) / PULSE_MS);
    for (const { ping } of this.#shown) drawPing(arena, map, this.#view, ping, pulse);
  }

  /** The pings that are shown now. */
  get shown() {
    return this.#shown.map(({ ping }) => ping);
  }

  /** @param {HTMLCanvasElement} canvas @param {PointerEvent} event */
  #tapped(canvas, event) {
    const map = this.game.round?.map;
    if (!map || this.#view === null || !this.possible || event.button !== 0) return;
    const point = arenaPoint(canvas.getBoundingClientRect(), { x: event.clientX, y: event.clientY });
    const item = itemAt(map, this.#view, this.game.own[0], point);
    if (item !== null) this.#send(this.game.own[0], item);
  }

  /** @param {number} seat @param {number} item */
  #send(seat, item) {
    if (this.possible && this.game.phase === "playing") this.actions.send({ type: "ping", seat, item });
  }
}

/** For screen readers: who asks for help, and with what. @param {ShownPing} ping @param {GameMap} map */
function sentence({ seat, item }, map) {
  return say(`play.announce.ping.${map.items[item]?.size ?? "place"}`, { who: colourName(seat) });
}
