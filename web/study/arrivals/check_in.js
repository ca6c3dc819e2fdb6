// @ts-check
/*
 * The check-in at a study page: who sits down at this screen, by a link, by a code or name that is asked for, beside
 * the first person, or after somebody who has finished.
 */

import { currentLanguage, sayError } from "../../text/catalogue.js";
import { browserLanguages, pickLanguage } from "../../text/language.js";
import { keepUnsentOf } from "../kept_answers.js";
import { forgetSecond, forgetSettings } from "../own_settings.js";
import { keepByLink, keepLink, loadPeople } from "../kept_people.js";
import { Place, arrive, titleOf } from "../service.js";
import { stillHere } from "../turns.js";
import { arrivalScreen } from "./arrival_screen.js";

/** @typedef {import("../service.js").View} View */

/**
 * @typedef {object} CheckInPage what the check-in needs of the page
 * @property {import("../service.js").Study} study
 * @property {import("../people_here.js").PeopleHere} here
 * @property {import("../frame.js").StudyFrame} frame
 * @property {import("../persistence.js").Persistence} persistence
 * @property {(language: string) => Promise<void>} follow switches to the language of the study's texts
 * @property {() => void} seated somebody sits here now: the page asks for their news and shows their step
 * @property {() => void} show the step of who sits here
 * @property {() => void} stay whoever has finished here goes on looking at their last screen
 */

export class CheckIn {
  #asksNext = false; // somebody finished here long ago, and another person may sit here now
  #known = loadPeople(); // at the start of this page
  #page;

  /** @param {CheckInPage} page */
  constructor(page) {
    this.#page = page;
  }

  /** Whether the next person is asked who they are, so that no step is shown. */
  get asksNext() {
    return this.#asksNext;
  }

  /** @param {Record<string, string>} parameters */
  async arriveByLink(parameters) {
    try {
      await this.#arrive(parameters);
      keepByLink(true);
    } catch (error) {
      this.askWho(sayError(error), parameters);
    }
  }

  /** @param {Record<string, string>} parameters @param {boolean} [second] beside the first person */
  async #arrive(parameters, second = false) {
    const { here, persistence } = this.#page;
    const beside = second ? here.tokens[0] : undefined;
    const { token, view, replaces, was_here } = await persistence.until(() =>
      arrive(parameters, currentLanguage(), beside, this.#known),
    );
    this.#asksNext = false;
    const replaced = this.#known[replaces ?? -1];
    const arrived = { place: new Place(token), view };
    const first = { place: here.places[0], view: here.views[0] };
    here.seat(second ? [first, arrived] : await this.#besideWhom(arrived, replaced));
    const expected = replaced && !second ? this.#known.filter((known) => known !== replaced) : [];
    keepUnsentOf(here.tokens, token, replaced, expected);
    if (!was_here) second ? forgetSecond() : forgetSettings();
    keepByLink(false);
    if (!second) keepLink(parameters);
    history.replaceState(null, "", location.pathname); // ids must not stay in the address bar
    await this.#page.follow(view.language);
    this.#page.seated();
  }

  /**
   * Who sits here once somebody has come back by their link: the other one of two stays, unless they went elsewhere.
   * @param {{place: Place, view: View}} arrived
   * @param {string | undefined} replaced the token that they had in this browser before
   */
  async #besideWhom(arrived, replaced) {
    const tokens = loadPeople();
    const token = replaced && tokens.includes(replaced) && tokens.find((one) => one !== replaced);
    if (!token) return [arrived];
    const place = new Place(token);
    const view = await this.#page.persistence.until(() => place.view()).catch(() => null); // their place may be gone
    if (!view || view.step.kind === "ended-elsewhere" || stillHere([view]).length === 0) return [arrived];
    return tokens[0] === replaced ? [arrived, { place, view }] : [{ place, view }, arrived];
  }

  /**
   * Whoever was here before keeps their place in this browser until somebody arrives.
   * @param {string} problem why the page asks again; empty the first time
   * @param {Record<string, string>} [given] parameters of the link
   */
  askWho(problem, given = {}) {
    this.#page.frame.setPlace(null, [], false);
    this.#showArrival(`arrival ${problem} ${currentLanguage()}`, { second: false, problem, given, cancel: null });
  }

  /** Whoever sits here now is asked in their own language, not in that of the person who has finished. */
  async askNext(language = pickLanguage(this.#page.study.languages, browserLanguages())) {
    this.#asksNext = true;
    await this.#page.follow(language);
    this.#page.frame.setPlace(null, [], false);
    const finished = () => {
      this.#asksNext = false;
      this.#page.stay();
    };
    const asked = { second: false, problem: "", given: {}, cancel: null, finished };
    this.#showArrival(`arrival-next ${currentLanguage()}`, asked);
  }

  askSecond() {
    this.#showArrival("arrival-2", { second: true, problem: "", given: {}, cancel: () => this.#page.show() });
  }

  /**
   * @param {string} id of the screen
   * @param {Omit<import("./arrival_screen.js").ArrivalOptions, "title" | "asksCode" | "arrive">} options
   */
  #showArrival(id, options) {
    const { study } = this.#page;
    const title = titleOf(study, currentLanguage());
    const arrive = (/** @type {Record<string, string>} */ parameters) => this.#arrive(parameters, options.second);
    this.#page.frame.show(id, () => arrivalScreen({ ...options, title, asksCode: study.asks_code, arrive }));
  }
}
