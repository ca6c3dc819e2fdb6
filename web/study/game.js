// @ts-check
/*
 * What the game page does differently in a round of a study: Stop asks about the data, practice may be ended early, and
 * after the last tick the page goes back to the study.
 */

import { problemBox, showProblem } from "../components/action.js";
import { byId, el } from "../core/dom.js";
import { say, sayError } from "../text/catalogue.js";
import { loadPeople } from "./kept_people.js";
import { Place } from "./service.js";
import { askToStop } from "./stop.js";

/** @typedef {import("../play/game.js").Game} Game */
/** @typedef {import("../text/study_mark.js").StudyMark} StudyMark */

const STUDY = "/study";
const READ_MS = 5000; // how long the end of a round is shown

export class StudyGame {
  #end = el("div", { class: "overlay overlay-end", hidden: true });
  #places = loadPeople().map((token) => new Place(token));
  #left = false;
  #asking = false;
  /** @type {import("../messages.js").Welcome | null} that the seats of this page were made ready after */
  #readyAfter = null;

  /** @param {StudyMark} mark */
  constructor(mark) {
    this.mark = mark;
    byId("arena-box", HTMLElement).append(this.#end);
    const round = byId("round", HTMLElement); // it counts the room's rounds, and a room of a study has one
    round.before(el("p", { class: "muted" }, mark.name));
    round.hidden = true;
    if (mark.practice) this.#offerEnough();
  }

  /** Whether a dialog is open, which then has the keys. */
  get isAsking() {
    return this.#asking;
  }

  /** Whether the end of the round covers the arena. */
  get showsResult() {
    return !this.#end.hidden;
  }

  /**
   * Whether to say now that everybody here is ready: the study's map card has asked already. Once per connection, and
   * not while the page is hidden: nobody shall miss the start.
   * @param {Game} game
   */
  startsNow({ welcome, phase }) {
    if (phase !== "lobby" || document.hidden || welcome === null || welcome === this.#readyAfter) return false;
    this.#readyAfter = welcome;
    return true;
  }

  /** Nothing to show: whoever stops a round of a study leaves the page. */
  stopHere() {}

  /** Back to the study. */
  leave() {
    if (this.#left) return;
    this.#left = true;
    location.assign(STUDY);
  }

  async askToStop() {
    if (this.#asking) return;
    this.#asking = true;
    const stopped = await askToStop(
      this.#places.map((_, person) => person),
      this.mark.pay ?? "paid",
      async (person, keep) => {
        await this.#places[person].stop(keep);
      },
    );
    this.#asking = false;
    if (stopped) this.leave();
  }

  /** @param {Game} game */
  update(game) {
    const over = game.phase === "round_over" || game.phase === "series_over";
    if (!over || this.showsResult) return;
    this.#end.hidden = false;
    setTimeout(() => this.leave(), READ_MS);
    if (game.tutorial?.finished) this.#showEndOf("play.tutorial.end", say("play.tutorial.endHelp"));
    else this.#showEnd(game.result);
  }

  /** @param {import("../play/game.js").RoundResult | null} result */
  #showEnd(result) {
    const title =
      { delivered: "study.play.overDelivered", time: "study.play.overTime" }[result?.outcome ?? ""] ??
      "study.play.overOther";
    const { delivered, items } = result ?? { delivered: 0, items: 0 };
    this.#showEndOf(title, items > 0 ? say("study.play.delivered", { delivered, items }) : "");
  }

  /** @param {string} title key of its text @param {string} sentence may be empty */
  #showEndOf(title, sentence) {
    const heading = el("h2", { tabindex: "-1" }, say(title));
    this.#end.replaceChildren(
      el(
        "section",
        { class: "card card-roomy stack panel" },
        heading,
        sentence ? el("p", {}, sentence) : null,
        el("p", { class: "muted" }, say("study.play.soon")),
        el(
          "div",
          { class: "row" },
          el(
            "button",
            { type: "button", class: "button button-primary", onclick: () => this.leave() },
            say("study.play.goOn"),
          ),
        ),
      ),
    );
    heading.focus({ preventScroll: true });
  }

  /** Adds the button that ends the practice. */
  #offerEnough() {
    const problem = problemBox();
    const button = el(
      "button",
      { type: "button", class: "button button-wide play-enough" },
      say(this.mark.tutorial ? "study.play.skip" : "study.play.enough"),
    );
    button.addEventListener("click", async () => {
      try {
        for (const place of this.#places) await place.next(this.mark.key, { done: true });
        this.leave();
      } catch (error) {
        showProblem(problem, sayError(error));
      }
    });
    const stop = byId("stop", HTMLButtonElement);
    stop.before(button, problem);
    stop.parentElement?.classList.add("stack");
  }
}
