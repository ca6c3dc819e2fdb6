// @ts-check
/*
 * The study page: the participants at this screen, the screen of their step, and the change to the game and back. The
 * server decides what comes next. Only the tokens are kept here, so a reload loses nothing.
 */

import { ApiError } from "../core/api.js";
import { Elapsed } from "../core/elapsed.js";
import { LiveStream } from "../core/live_stream.js";
import { saveTokens } from "../wire/seat_tokens.js";
import { arrivalScreen, recruitmentParameters } from "./arrival.js";
import { StudyFrame } from "./frame.js";
import { markStudyRound } from "../text/study_mark.js";
import { areUndecided, cameByLink, keepByLink, keepLink, loadLink } from "./people.js";
import { loadPeople, savePeople, seatsToTake, stillHere, whoseTurn } from "./people.js";
import { dropUnsentOf, keepUnsentOf } from "./kept_answers.js";
import { forgetSecond, forgetSettings } from "./own_settings.js";
import { Persistence } from "./persistence.js";
import { roundName } from "./round.js";
import { SCREENS } from "./screens.js";
import { Place, arrive, titleOf } from "./service.js";
import { askToStop } from "./stop.js";
import { DEFAULT_LANGUAGE, browserLanguages, hasWords, keepLanguage, pickLanguage } from "../text/language.js";
import { currentLanguage, say, sayError, useLanguage } from "../text/catalogue.js";

/** @typedef {import("./service.js").View} View */
/** @typedef {import("./screen.js").Context} Context */

const POLL_MS = 10_000;
const POLL_PLAYING_MS = 2000; // somebody may be coming back from the game
const CLOCK_MS = 1000;
const OFFERS_SECOND = ["consent", "waiting", "paused"]; // screens that stay behind the form for the second person

export class StudyPage {
  #persistence = new Persistence((problem) => this.#frame.setProblem(problem));
  /** @type {Place[]} */
  #places = [];
  /** @type {View[]} */
  #views = [];
  /** @type {LiveStream[]} */
  #streams = [];
  #news = new Elapsed(); // since the newest view came, or was asked for
  #asking = false;
  #askedFor = ""; // key of the round whose card was shown here
  #readyFor = ""; // key of the round for which "I am ready" was said in this tab: another one leaves the game to it
  #codeOf = 0;
  #stepShown = "";
  /** @type {import("./screen.js").Kept} */
  #kept = {};
  #asksNext = false; // somebody finished here long ago, and another person may sit here now
  #known = loadPeople(); // at the start of this page
  #frame = new StudyFrame({ language: (language) => void this.#setLanguage(language), stop: () => void this.#stop() });

  /** @param {import("./service.js").Study} study */
  constructor(study) {
    this.study = study;
  }

  async start() {
    this.#frame.setTexts(this.study);
    setInterval(() => this.#tick(), CLOCK_MS);
    addEventListener("pageshow", (event) => event.persisted && location.reload()); // back from the game: stale
    const parameters = recruitmentParameters(location.search);
    if (Object.keys(parameters).length > 0) return this.#arriveByLink(parameters);
    const tokens = loadPeople();
    const link = loadLink();
    if (tokens.length === 0) return link ? this.#arriveByLink(link) : this.#askWho("");
    this.#places = tokens.map((token) => new Place(token));
    await this.#refresh();
    this.#listen();
    if (this.#views.length > 0 && this.#views.every(({ step }) => step.long_ago)) await this.#askNext();
  }

  // ---- arriving ---------------------------------------------------------------------------------------------

  /** @param {Record<string, string>} parameters */
  async #arriveByLink(parameters) {
    try {
      await this.#arrive(parameters);
      keepByLink(true);
    } catch (error) {
      this.#askWho(sayError(error), parameters);
    }
  }

  /** @param {Record<string, string>} parameters @param {boolean} [second] beside the first person */
  async #arrive(parameters, second = false) {
    const beside = second ? this.#places[0]?.token : undefined;
    const { token, view, replaces, was_here } = await this.#persistence.until(() =>
      arrive(parameters, currentLanguage(), beside, this.#known),
    );
    this.#asksNext = false;
    const replaced = this.#known[replaces ?? -1];
    const here = { place: new Place(token), view };
    const first = { place: this.#places[0], view: this.#views[0] };
    const people = second ? [first, here] : await this.#besideWhom(here, replaced);
    this.#places = people.map(({ place }) => place);
    this.#views = people.map(({ view }) => view);
    savePeople(this.#tokens);
    const expected = replaced && !second ? this.#known.filter((known) => known !== replaced) : [];
    keepUnsentOf(this.#tokens, token, replaced, expected);
    if (!was_here) second ? forgetSecond() : forgetSettings();
    keepByLink(false);
    if (!second) keepLink(parameters);
    history.replaceState(null, "", location.pathname); // ids must not stay in the address bar
    await this.#follow(view.language);
    this.#listen();
    this.#show();
  }

  /**
   * Who sits here once somebody has come back by their link: the other one of two stays, unless they went elsewhere.
   * @param {{place: Place, view: View}} here
   * @param {string | undefined} replaced the token that they had in this browser before
   */
  async #besideWhom(here, replaced) {
    const tokens = loadPeople();
    const token = replaced && tokens.includes(replaced) && tokens.find((one) => one !== replaced);
    if (!token) return [here];
    const place = new Place(token);
    const view = await this.#persistence.until(() => place.view()).catch(() => null); // their place may be gone
    if (!view || view.step.kind === "ended-elsewhere" || stillHere([view]).length === 0) return [here];
    return tokens[0] === replaced ? [here, { place, view }] : [{ place, view }, here];
  }

  /**
   * Whoever was here before keeps their place in this browser until somebody arrives.
   * @param {string} problem why the page asks again; empty the first time
   * @param {Record<string, string>} [given] parameters of the link
   */
  #askWho(problem, given = {}) {
    this.#frame.setPlace(null, [], false);
    this.#showArrival(`arrival ${problem} ${currentLanguage()}`, { second: false, problem, given, cancel: null });
  }

  /** Whoever sits here now is asked in their own language, not in that of the person who has finished. */
  async #askNext(language = pickLanguage(this.study.languages, browserLanguages())) {
    this.#asksNext = true;
    await this.#follow(language);
    this.#frame.setPlace(null, [], false);
    const finished = () => {
      this.#asksNext = false;
      void this.#takeAll(this.#views);
    };
    const asked = { second: false, problem: "", given: {}, cancel: null, finished };
    this.#showArrival(`arrival-next ${currentLanguage()}`, asked);
  }

  #askSecond() {
    this.#showArrival("arrival-2", { second: true, problem: "", given: {}, cancel: () => this.#show() });
  }

  /**
   * @param {string} id of the screen
   * @param {Omit<import("./arrival.js").ArrivalOptions, "title" | "asksCode" | "arrive">} options
   */
  #showArrival(id, options) {
    const { asks_code: asksCode } = this.study;
    const title = titleOf(this.study, currentLanguage());
    const arrive = (/** @type {Record<string, string>} */ parameters) => this.#arrive(parameters, options.second);
    this.#frame.show(id, () => arrivalScreen({ ...options, title, asksCode, arrive }));
  }

  /** The place that this browser has is given up. @param {string} problem why, empty where a person wants it */
  #leave(problem) {
    const gone = this.#tokens;
    this.#forget();
    const again = problem && loadLink() !== null; // the study was mended while they read the consent
    again ? location.reload() : this.#askWho(problem);
    dropUnsentOf(gone); // with what the screen that closed has kept
  }

  #forget() {
    for (const stream of this.#streams) stream.close();
    this.#streams = [];
    this.#places = [];
    this.#views = [];
    this.#codeOf = 0;
    savePeople([]);
  }

  // ---- news -------------------------------------------------------------------------------------------------

  #listen() {
    for (const stream of this.#streams) stream.close();
    this.#streams = this.#places.map((place, person) =>
      new LiveStream("/api/study/events", place.token, {
        onNews: (news) => void (news.view ? this.#take(person, news.view) : this.#refresh()),
      }).open(),
    );
  }

  #tick() {
    const playing = this.#views.some(({ step }) => step.state === "playing");
    if (this.#news.ms > (playing ? POLL_PLAYING_MS : POLL_MS)) void this.#refresh();
  }

  async #refresh() {
    if (this.#asking || this.#places.length === 0) return;
    this.#asking = true;
    this.#news.restart();
    try {
      const places = this.#places;
      const views = await this.#persistence.until(() => Promise.all(places.map((place) => place.view())));
      if (places === this.#places) await this.#takeAll(views);
    } catch (error) {
      this.#lost(error);
    } finally {
      this.#asking = false;
    }
  }

  /** @param {unknown} error */
  #lost(error) {
    const sentence = sayError(error);
    if (error instanceof ApiError && (error.status === 401 || error.status === 404)) this.#leave(sentence);
    else this.#frame.showProblem(sentence, () => void this.#refresh());
  }

  /** @param {number} person @param {View} view */
  async #take(person, view) {
    await this.#takeAll(this.#places.map((_, index) => (index === person ? view : this.#views[index])).filter(Boolean));
  }

  /** @param {View[]} views */
  async #takeAll(views) {
    if (views.length < this.#places.length) return; // the other person's view is still to come
    this.#views = this.#withoutDeclined(views);
    this.#news.restart();
    if (this.#asksNext) return;
    const [{ language, step }] = this.#views;
    if (step.kind !== "ended-elsewhere") await this.#follow(language); // nobody's page keeps the language that it has
    this.#show();
  }

  /**
   * Views that were asked for at places: where others sit here by now, the server is asked about those.
   * @param {Place[]} places @param {View[]} views
   */
  async #takeAllOf(places, views) {
    await (places === this.#places ? this.#takeAll(views) : this.#refresh());
  }

  /** Of two, the one who stays when the other has declined. @param {View[]} views */
  #withoutDeclined(views) {
    const staying = stillHere(views);
    if (views.length < 2 || staying.length !== 1) return views;
    this.#places = staying.map((person) => this.#places[person]);
    savePeople(this.#tokens);
    this.#listen();
    return staying.map((person) => views[person]);
  }

  // ---- what is shown ----------------------------------------------------------------------------------------

  #show() {
    if (!areUndecided(this.#views)) keepLink({});
    const people = this.#turn();
    const steps = people.map((person) => this.#views[person].step);
    const [step] = steps;
    this.#frame.setPlace(this.#views[this.#whoCanStop[0] ?? people[0]], people, this.#places.length > 1);
    if (this.#frame.shows("arrival-2") && OFFERS_SECOND.includes(step.kind) && this.#places.length < 2) return;
    if (step.state === "card") this.#askedFor = step.key;
    if (step.state === "waiting" && step.key !== this.#askedFor) this.#readyFor = step.key; // said before a reload
    if (step.state === "playing" && step.key === this.#readyFor && this.#play(steps)) return;
    const make = SCREENS[step.kind];
    const { key, kind, state, room, version } = step;
    const shown = JSON.stringify([people, this.#places.length, key, kind, state, Boolean(room), version]);
    if (shown !== this.#stepShown) this.#kept = {};
    this.#stepShown = shown;
    if (make) this.#frame.show(`${shown} ${currentLanguage()}`, () => make(this.#context(people)), step);
    else this.#frame.showProblem(say("error.http"), () => location.reload());
    dropUnsentOf(this.#tokens.filter((_, person) => this.#views[person]?.step.kind === "code"));
  }

  get #tokens() {
    return this.#places.map((place) => place.token);
  }

  #turn() {
    const people = whoseTurn(this.#views);
    const finished = this.#views.every(({ step }) => step.kind === "code");
    return finished && this.#views.length > 1 ? [this.#codeOf] : people;
  }

  get #whoCanStop() {
    return this.#turn().filter((person) => this.#views[person].can_stop);
  }

  /** @param {number[]} people @returns {Context} */
  #context(people) {
    const steps = people.map((person) => this.#views[person].step);
    const place = this.#places[people[0]];
    const two = this.#places.length > 1;
    const bothDone = two && this.#views.every(({ step }) => step.kind === "code");
    const key = steps[0].key;
    return {
      step: steps[0],
      kept: this.#kept,
      steps,
      people,
      place,
      several: two,
      next: (given) => {
        if (steps[0].state === "card") this.#readyFor = key;
        return this.#each(people, (one, index) => one.next(key, Array.isArray(given) ? given[index] : given));
      },
      decline: () => this.#each(people, (one) => one.decline()),
      play: () => void this.#play(this.#turn().map((person) => this.#views[person].step)),
      addPerson: this.study.one_screen && !two ? () => this.#askSecond() : null,
      pay: this.#pay,
      leaveScreen: cameByLink() ? null : () => this.#leave(""),
      nextCode: bothDone ? () => this.#otherCode() : null,
      refresh: () => this.#news.ms > POLL_PLAYING_MS && void this.#refresh(),
    };
  }

  get #pay() {
    return this.study.pays === false ? "unpaid" : "paid";
  }

  #otherCode() {
    this.#codeOf = 1 - this.#codeOf;
    this.#show();
  }

  /**
   * Asks for one person after the other, until each has an answer.
   * @param {number[]} people
   * @param {(place: Place, index: number) => Promise<View>} ask
   */
  async #each(people, ask) {
    const places = this.#places;
    const views = [...this.#views];
    for (const [index, person] of people.entries())
      views[person] = await this.#persistence.until(() => ask(places[person], index));
    await this.#takeAllOf(places, views);
  }

  /** Goes to the room, once every seat of this screen is known. @param {import("./service.js").Step[]} steps */
  #play(steps) {
    const seats = seatsToTake(steps);
    if (seats === null) return false;
    saveTokens(seats.id, seats.tokens);
    const [{ key, kind, map, map_named: named, title }] = steps;
    const language = currentLanguage();
    markStudyRound({
      room: seats.id,
      key,
      practice: kind === "practice",
      tutorial: steps[0].tutorial === true,
      sounds: steps[0].sounds === true,
      pay: this.#pay,
      language,
      name: roundName(steps[0]),
      people: seats.people,
      ...(named && map && title ? { map: { name: map.name, title } } : {}),
    });
    location.assign(seats.path);
    return true;
  }

  async #stop() {
    const people = this.#whoCanStop;
    const places = this.#places;
    const stopped = await askToStop(people, this.#pay, async (person, keep) => {
      const view = await this.#persistence.until(() => places[person].stop(keep));
      if (places === this.#places) this.#views[person] = view;
    });
    if (stopped) await this.#takeAllOf(places, [...this.#views]);
  }

  // ---- language ---------------------------------------------------------------------------------------------

  /** @param {string} language */
  async #setLanguage(language) {
    keepLanguage(language);
    if (this.#asksNext) return this.#askNext(language);
    if (this.#places.length === 0) {
      await this.#follow(language);
      this.#askWho("", recruitmentParameters(location.search)); // of a link that was refused
      return;
    }
    if (this.#views[0]?.step.kind === "ended-elsewhere") await this.#follow(language);
    const places = this.#places;
    const views = await this.#persistence.until(() => Promise.all(places.map((place) => place.view(language))));
    await this.#takeAllOf(places, views);
  }

  /** Switches to the language of the study's texts, where the pages have its words. @param {string} language */
  async #follow(language) {
    const wanted = hasWords(language) ? language : DEFAULT_LANGUAGE;
    if (wanted === currentLanguage()) return;
    await this.#persistence.until(() => useLanguage(wanted));
    this.#frame.setTexts(this.study);
  }
}
