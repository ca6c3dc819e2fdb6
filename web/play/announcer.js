// The polite live region: at most one sentence per second, the newest. The clock is not read out.

import { byId } from "../core/dom.js";
import { ticksOf } from "../core/ticks.js";
import { say } from "../text/catalogue.js";
import { companyText, isOver, reasonText } from "./seat_phrases.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("./game.js").Scene} Scene */

const QUIET_MS = 1000;

export class Announcer {
  #region = byId("live", HTMLElement);
  #saidAtMs = -Infinity;
  #next = "";
  #before = { phase: "", delivered: 0, stalled: false, tick: 0, company: "" };

  /** @param {Game} game @param {Scene} scene @param {number} nowMs */
  update(game, scene, nowMs) {
    const { phase } = game;
    const delivered = scene.view.delivered.filter(Boolean).length;
    const before = this.#before;
    const company = companyText(game.room, game.own);
    this.#before = { phase, delivered, stalled: scene.stalled, tick: scene.tick, company };
    const limit = game.round?.limit_ticks ?? 0;
    const seen = limit > 0 && before.tick > 0; // who comes later has not seen what passed before
    const passed = (/** @type {number} */ tick) => seen && before.tick < tick && scene.tick >= tick;
    if ((phase === "lobby" || isOver(phase)) && phase === before.phase && company !== before.company)
      this.#next = company;
    if (game.overBeforeRound && before.phase !== phase) this.#next = reasonText(game.room, game.own);
    if (phase === "countdown" && before.phase !== "countdown") this.#next = say("play.announce.countdown");
    if (phase === "playing" && before.phase !== "playing") this.#next = say("play.announce.start");
    if (phase === "paused" && before.phase !== "paused")
      this.#next = say("play.announce.paused", { reason: reasonText(game.room, game.own) });
    if (passed(limit / 2)) this.#next = say("play.announce.halfTime");
    if (passed(limit - ticksOf(10))) this.#next = say("play.announce.tenSeconds");
    if (scene.stalled && !before.stalled) this.#next = say("play.announce.stalled");
    if (delivered !== before.delivered)
      this.#next = say("play.announce.delivered", { done: delivered, total: scene.view.delivered.length });
    if (this.#next !== "" && nowMs - this.#saidAtMs >= QUIET_MS) this.#say(nowMs);
  }

  /** Says a sentence with the next update. @param {string} sentence */
  announce(sentence) {
    this.#next = sentence;
  }

  /** @param {number} nowMs */
  #say(nowMs) {
    this.#region.textContent = this.#next;
    this.#saidAtMs = nowMs;
    this.#next = "";
  }
}
