// What follows a round on this page: its result with the ways on, and for whoever wants it the questions about the
// partner. Has the order of these views, not their look.

import { FINISHED } from "../messages.js";
import { badge, byId, el } from "../core/dom.js";
import { problemBox, showProblem } from "../components/action.js";
import { showQuestionnaire } from "./room_questionnaire.js";
import { showResult } from "./result/result.js";
import { say, sayError } from "../text/catalogue.js";
import { colourName } from "../text/names.js";
import { countRound } from "./result/best_rounds.js";
import { goOn, sameSeats } from "./next_game.js";
import { companyText, heldText, isOver, reasonText, seatName } from "./seat_phrases.js";
import { shareButtons } from "./result/share_round.js";
import { isDrawnIn, keepPlayed, seedOf } from "../wire/played_map.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("../view/render.js").View} View */
/**
 * @typedef {object} Actions
 * @property {() => void} next  everybody here is ready for the next round
 * @property {() => void} again  the same map once more
 */

const LEAVING_MS = 5000; // until a page that was to be left may be left once more
/** @type {readonly string[]} */
const COMPLETE = FINISHED;

export class AfterRound {
  #play = byId("play", HTMLElement);
  #arena = byId("arena-box", HTMLElement);
  #box = byId("result", HTMLElement);
  #after = byId("after", HTMLElement);
  /** @type {import("./game.js").RoundResult | null} */
  #shown = null;
  #stoppedHere = false;
  #asked = false; // for a further round in this room
  #going = false; // a further room is being opened
  #problem = problemBox();
  #company = el("p", { class: "muted result-company" }); // the announcer says it aloud

  /** @param {Actions} actions */
  constructor(actions) {
    this.actions = actions;
    addEventListener("pageshow", (event) => event.persisted && (this.#going = false)); // back from the further room
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
    const over = isOver(game.phase);
    if (over && game.result !== null && this.#isNew(game.result)) this.#showResult(game, view);
    const answered = this.#asked && game.own.some((seat) => game.room?.seats[seat]?.ready);
    if (this.showsResult && (!over || (answered && !heldText(game.room)))) this.#hideResult();
    const told = over && game.own.length > 0 && COMPLETE.includes(game.result?.outcome ?? "");
    const company = told ? companyText(game.room, game.own) : ""; // why a round was cut short is in its result
    if (company !== this.#company.textContent) this.#company.textContent = company;
  }

  /**
   * A connection that is back brings the result once more: what is shown of it stays as its reader left it.
   * @param {import("./game.js").RoundResult} result
   */
  #isNew(result) {
    if (result === this.#shown) return false;
    const isRepeated = this.showsResult && JSON.stringify(result) === JSON.stringify(this.#shown);
    this.#shown = result;
    return !isRepeated;
  }

  /** @param {Game} game @param {View} view */
  #showResult(game, view) {
    const { result, round, own } = game;
    if (result === null || round === null) return;
    this.#arena.hidden = true;
    this.#box.hidden = false;
    this.#play.toggleAttribute("data-result", true);
    const counts = own.length > 0 && COMPLETE.includes(result.outcome) && !round.practice;
    showResult(this.#box, {
      result,
      round,
      view,
      names: seatNames(game),
      plays: own.length > 0,
      stoppedHere: this.#stoppedHere,
      reason: reasonText(game.room, own),
      best: counts ? countRound(round, result) : null,
      ways: this.#ways(game, result.outcome),
      sharing: this.#sharing(game, result.recording),
      company: this.#company,
      problem: this.#problem,
      asides: counts && game.phase === "series_over" ? [this.#questions(game)] : [],
    });
  }

  /**
   * How to play on, the main way first.
   * @param {Game} game @param {string} outcome
   * @returns {import("./result/result.js").Way[]}
   */
  #ways(game, outcome) {
    const start = { text: say("play.over.lobby"), href: "/" };
    const seats = sameSeats(game.room?.seats ?? [], game.own);
    const over = game.phase === "series_over";
    const again = { text: say("play.result.again"), onclick: () => this.#playOn(this.actions.again) };
    const anew = { text: say("play.result.again"), onclick: () => void this.#goOn(game, "same") };
    const next = { text: say("play.result.next"), onclick: () => void this.#goOn(game, "next") };
    if (game.own.length === 0) return [start];
    if (!over) return [{ text: say("play.result.next"), onclick: () => this.#playOn(this.actions.next) }, again, start];
    if (game.round?.practice) return [start, again];
    const repeat = COMPLETE.includes(outcome) ? again : seats ? anew : null;
    const other = { text: say("play.result.partner"), ...toChoose(game.round) };
    const edit = isDrawnIn(game.welcome?.room ?? "") ? { text: say("play.result.edit"), href: "/editor" } : null;
    return [seats ? next : null, repeat, seats ? other : null, edit, start].filter((way) => way !== null);
  }

  /** @param {Game} game @param {string} recording */
  #sharing(game, recording) {
    const { welcome } = game;
    if (!recording || !welcome) return [];
    const replay = { class: "button button-small", href: `/replay/${recording}`, target: "_blank", rel: "noopener" };
    const [seat] = game.own;
    return [
      el("a", replay, say("play.result.replay")),
      ...(seat === undefined ? [] : [shareButtons({ room: welcome.room, token: () => game.tokenOf(seat), recording })]),
    ];
  }

  /** The questions are there for whoever wants to answer them; nobody has to pass them. @param {Game} game */
  #questions(game) {
    const ask = el("button", { type: "button", class: "button-link" }, say("play.result.questions"));
    ask.addEventListener("click", () => {
      this.#play.hidden = true;
      this.#after.hidden = false;
      this.#ask(game, [...game.own], ask);
    });
    return ask;
  }

  /** @param {Game} game @param {"next" | "same"} which */
  async #goOn(game, which) {
    if (this.#going) return;
    this.#going = true;
    try {
      await goOn(game, which);
      setTimeout(() => (this.#going = false), LEAVING_MS); // where the page is still there
    } catch (error) {
      this.#going = false;
      showProblem(this.#problem, sayError(error));
    }
  }

  #hideResult() {
    this.#asked = false;
    this.#box.hidden = true;
    this.#box.replaceChildren();
    this.#play.toggleAttribute("data-result", false);
    this.#arena.hidden = false;
  }

  /**
   * A further round in this room: the server says whether one can begin yet, and until it can the result stays.
   * @param {() => void} action
   */
  #playOn(action) {
    this.#asked = true;
    action();
  }

  /**
   * One person after the other, then back to the result.
   * @param {Game} game @param {number[]} seats of those still to be asked @param {HTMLElement} from what led here
   */
  #ask(game, seats, from) {
    const seat = seats.shift();
    const states = game.room?.seats;
    if (seat === undefined || states === undefined) {
      this.#thank(from);
      return;
    }
    const box = el("div");
    const several = game.own.length > 1;
    const who = several
      ? [el("p", { class: "agent lead" }, badge(seat), say("play.over.questionsFor", { colour: colourName(seat) }))]
      : [];
    this.#after.replaceChildren(...who, box);
    scrollTo(0, 0);
    const partnerName = several ? colourName(1 - seat) : seatName(states[1 - seat], false);
    const onDone = () => this.#ask(game, seats, from);
    const onSkip = () => this.#backToResult(from);
    const token = () => game.tokenOf(seat);
    void showQuestionnaire(box, { room: game.welcome?.room ?? "", token, partnerName, onDone, onSkip });
  }

  /** @param {HTMLElement} from what led to the questions */
  #thank(from) {
    const thanks = el("p", { class: "result-thanks", role: "status", tabindex: "-1" }, say("play.result.thanks"));
    from.replaceWith(thanks);
    this.#backToResult(thanks);
  }

  /** @param {HTMLElement} focus */
  #backToResult(focus) {
    this.#after.hidden = true;
    this.#after.replaceChildren();
    this.#play.hidden = false;
    focus.focus();
  }
}

/** To the lobby with the map that was played, and the number of shuffled items. @param {Game["round"]} round */
function toChoose(round) {
  const name = encodeURIComponent(round?.map.name ?? "");
  const seed = round ? seedOf(round.map) : null;
  const shuffled = seed === null ? "" : `&seed=${seed}`;
  return { href: `/?map=${name}${shuffled}#partner`, onclick: () => round && keepPlayed(round.map) };
}

/** What to call the players of a round. @param {Game} game */
function seatNames({ room, own }) {
  const several = own.length > 1;
  return (room?.seats ?? []).map((seat, index) =>
    several ? colourName(index) : seatName(seat, own.includes(index), own.length === 0),
  );
}
