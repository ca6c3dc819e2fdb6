// What follows a round on this page: its result, and after the last round the questions for each person here and the
// thanks. Has the order of these views, not their look.

import { badge, byId, el } from "../core/dom.js";
import { showQuestionnaire } from "./room_questionnaire.js";
import { showResult } from "./result.js";
import { say } from "../text/catalogue.js";
import { colourName } from "../text/names.js";
import { seatName } from "./seat_phrases.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("../view/render.js").View} View */
/**
 * @typedef {object} Actions
 * @property {() => void} next  everybody here is ready for the next round
 * @property {() => void} again  the same map once more
 * @property {() => void} leave  the series is over for this page
 */

const COMPLETE = ["delivered", "time"];

export class Series {
  #play = byId("play", HTMLElement);
  #arena = byId("arena-box", HTMLElement);
  #box = byId("result", HTMLElement);
  #after = byId("after", HTMLElement);
  /** @type {import("./game.js").RoundResult | null} */
  #shown = null;
  #stoppedHere = false;

  /** @param {Actions} actions */
  constructor(actions) {
    this.actions = actions;
  }

  /** Somebody on this page stopped the round. */
  stopHere() {
    this.#stoppedHere = true;
  }

  /** Whether a result covers the arena. */
  get showsResult() {
    return !this.#box.hidden;
  }

  /** @param {Game} game @param {View} view */
  update(game, view) {
    const over = game.phase === "round_over" || game.phase === "series_over";
    if (over && game.result !== null && game.result !== this.#shown) this.#showResult(game, view);
    if (!over && this.showsResult) this.#hideResult();
  }

  /** @param {Game} game @param {View} view */
  #showResult(game, view) {
    const { result, round, own } = game;
    if (result === null || round === null) return;
    this.#shown = result;
    this.#arena.hidden = true;
    this.#box.hidden = false;
    const isLast = game.phase === "series_over";
    const plays = own.length > 0;
    const replayPath = result.recording ? `/replay/${result.recording}` : undefined;
    showResult(this.#box, {
      result,
      round,
      isLast,
      view,
      replayPath,
      stoppedHere: this.#stoppedHere,
      onNext: plays ? () => (isLast ? this.#finish(game, result.outcome) : this.#next()) : undefined,
      onAgain: plays && COMPLETE.includes(result.outcome) ? () => this.#again() : undefined,
    });
  }

  #hideResult() {
    this.#box.hidden = true;
    this.#box.replaceChildren();
    this.#arena.hidden = false;
  }

  #next() {
    this.#hideResult();
    this.actions.next();
  }

  #again() {
    this.#hideResult();
    this.actions.again();
  }

  /** @param {Game} game @param {string} outcome */
  #finish(game, outcome) {
    this.#play.hidden = true;
    this.#after.hidden = false;
    const asks = COMPLETE.includes(outcome) && game.round?.practice !== true;
    if (asks) this.#ask(game, [...(game.welcome?.seats ?? [])]);
    else this.#thank();
  }

  /** One person after the other. @param {Game} game @param {import("../messages.js").SeatGrant[]} grants */
  #ask(game, grants) {
    const grant = grants.shift();
    const seats = game.room?.seats;
    if (grant === undefined || seats === undefined) {
      this.#thank();
      return;
    }
    const box = el("div");
    const several = (game.welcome?.seats.length ?? 0) > 1;
    const who = several
      ? [
          el(
            "p",
            { class: "agent lead" },
            badge(grant.seat),
            say("play.over.questionsFor", { colour: colourName(grant.seat) }),
          ),
        ]
      : [];
    this.#after.replaceChildren(...who, box);
    scrollTo(0, 0);
    const partnerName = several ? colourName(1 - grant.seat) : seatName(seats[1 - grant.seat], false);
    const onDone = () => this.#ask(game, grants);
    void showQuestionnaire(box, { room: game.welcome?.room ?? "", token: grant.token, partnerName, onDone });
  }

  #thank() {
    this.actions.leave();
    const title = el("h1", { tabindex: "-1" }, say("play.over.title"));
    const back = el("a", { class: "button button-primary", href: "/" }, say("play.over.lobby"));
    this.#after.replaceChildren(
      el(
        "div",
        { class: "stack" },
        title,
        el("p", { class: "lead" }, say("play.over.sentence")),
        el("div", { class: "row" }, back),
      ),
    );
    title.focus();
  }
}
