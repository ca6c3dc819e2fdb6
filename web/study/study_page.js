// @ts-check
/*
 * The study page: the participants at this screen, the screen of their step, and the change to the game and back. The
 * server decides what comes next. Only the tokens are kept here, so a reload loses nothing.
 */

import { ApiError } from "../core/api.js";
import { Elapsed } from "../core/elapsed.js";
import { LiveStream } from "../core/live_stream.js";
import { saveTokens } from "../wire/seat_tokens.js";
import { CheckIn } from "./arrivals/check_in.js";
import { recruitmentParameters } from "./arrivals/recruitment_link.js";
import { StudyFrame } from "./frame.js";
import { markStudyRound } from "../text/study_mark.js";
import { dropUnsentOf } from "./kept_answers.js";
import { cameByLink, keepLink, loadLink, loadPeople } from "./kept_people.js";
import { PeopleHere } from "./people_here.js";
import { Persistence } from "./persistence.js";
import { roundName } from "./round.js";
import { SCREENS } from "./screens.js";
import { askToStop } from "./stop.js";
import { areUndecided, seatsToTake } from "./turns.js";
import { DEFAULT_LANGUAGE, hasWords, keepLanguage } from "../text/language.js";
import { currentLanguage, say, sayError, useLanguage } from "../text/catalogue.js";

/** @typedef {import("./service.js").Place} Place */
/** @typedef {import("./service.js").View} View */
/** @typedef {import("./screen.js").Context} Context */

const POLL_MS = 10_000;
const POLL_PLAYING_MS = 2000; // somebody may be coming back from the game
const CLOCK_MS = 1000;
const OFFERS_SECOND = ["consent", "waiting", "paused"]; // screens that stay behind the form for the second person

export class StudyPage {
  #persistence = new Persistence((problem) => this.#frame.setProblem(problem));
  #here = new PeopleHere();
  /** @type {LiveStream[]} */
  #streams = [];
  #news = new Elapsed(); // since the newest view came, or was asked for
  #asking = false;
  #askedFor = ""; // key of the round whose card was shown here
  #readyFor = ""; // key of the round for which "I am ready" was said in this tab: another one leaves the game to it
  #stepShown = "";
  /** @type {import("./screen.js").Kept} */
  #kept = {};
  #frame = new StudyFrame({ language: (language) => void this.#setLanguage(language), stop: () => void this.#stop() });

  #checkIn;

  /** @param {import("./service.js").Study} study */
  constructor(study) {
    this.study = study;
    this.#checkIn = new CheckIn({
      study,
      here: this.#here,
      frame: this.#frame,
      persistence: this.#persistence,
      follow: (language) => this.#follow(language),
      seated: () => {
        this.#listen();
        this.#show();
      },
      show: () => this.#show(),
      stay: () => void this.#takeAll(this.#here.views),
    });
  }

  async start() {
    this.#frame.setTexts(this.study);
    setInterval(() => this.#tick(), CLOCK_MS);
    addEventListener("pageshow", (event) => event.persisted && location.reload()); // back from the game: stale
    const parameters = recruitmentParameters(location.search);
    if (Object.keys(parameters).length > 0) return this.#checkIn.arriveByLink(parameters);
    const tokens = loadPeople();
    const link = loadLink();
    if (tokens.length === 0) return link ? this.#checkIn.arriveByLink(link) : this.#checkIn.askWho("");
    this.#here.remember(tokens);
    await this.#refresh();
    this.#listen();
    const { views } = this.#here;
    if (views.length > 0 && views.every(({ step }) => step.long_ago)) await this.#checkIn.askNext();
  }

  // ---- leaving ----------------------------------------------------------------------------------------------

  /** The place that this browser has is given up. @param {string} problem why, empty where a person wants it */
  #leave(problem) {
    const gone = this.#here.tokens;
    this.#closeStreams();
    this.#here.forget();
    const again = problem && loadLink() !== null; // the study was mended while they read the consent
    again ? location.reload() : this.#checkIn.askWho(problem);
    dropUnsentOf(gone); // with what the screen that closed has kept
  }

  // ---- news -------------------------------------------------------------------------------------------------

  #listen() {
    this.#closeStreams();
    this.#streams = this.#here.places.map((place, person) =>
      new LiveStream("/api/study/events", place.token, {
        onNews: (news) => void (news.view ? this.#take(person, news.view) : this.#refresh()),
      }).open(),
    );
  }

  #closeStreams() {
    for (const stream of this.#streams) stream.close();
    this.#streams = [];
  }

  #tick() {
    const playing = this.#here.views.some(({ step }) => step.state === "playing");
    if (this.#news.ms > (playing ? POLL_PLAYING_MS : POLL_MS)) void this.#refresh();
  }

  async #refresh() {
    if (this.#asking || this.#here.places.length === 0) return;
    this.#asking = true;
    this.#news.restart();
    try {
      const places = this.#here.places;
      const views = await this.#persistence.until(() => Promise.all(places.map((place) => place.view())));
      if (places === this.#here.places) await this.#takeAll(views);
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
    await this.#takeAll(
      this.#here.places.map((_, index) => (index === person ? view : this.#here.views[index])).filter(Boolean),
    );
  }

  /** @param {View[]} views */
  async #takeAll(views) {
    if (views.length < this.#here.places.length) return; // the other person's view is still to come
    if (this.#here.take(views)) this.#listen();
    this.#news.restart();
    if (this.#checkIn.asksNext) return;
    const [{ language, step }] = this.#here.views;
    if (step.kind !== "ended-elsewhere") await this.#follow(language); // nobody's page keeps the language that it has
    this.#show();
  }

  /**
   * Views that were asked for at places: where others sit here by now, the server is asked about those.
   * @param {Place[]} places @param {View[]} views
   */
  async #takeAllOf(places, views) {
    await (places === this.#here.places ? this.#takeAll(views) : this.#refresh());
  }

  // ---- what is shown ----------------------------------------------------------------------------------------

  #show() {
    if (!areUndecided(this.#here.views)) keepLink({});
    const people = this.#here.turn;
    const steps = this.#here.steps(people);
    const [step] = steps;
    this.#frame.setPlace(this.#here.views[this.#here.whoCanStop[0] ?? people[0]], people, this.#here.areTwo);
    if (this.#frame.shows("arrival-2") && OFFERS_SECOND.includes(step.kind) && !this.#here.areTwo) return;
    if (step.state === "card") this.#askedFor = step.key;
    if (step.state === "waiting" && step.key !== this.#askedFor) this.#readyFor = step.key; // said before a reload
    if (step.state === "playing" && step.key === this.#readyFor && this.#play(steps)) return;
    const make = SCREENS[step.kind];
    const { key, kind, state, room, version } = step;
    const shown = JSON.stringify([people, this.#here.places.length, key, kind, state, Boolean(room), version]);
    if (shown !== this.#stepShown) this.#kept = {};
    this.#stepShown = shown;
    if (make) this.#frame.show(`${shown} ${currentLanguage()}`, () => make(this.#context(people)), step);
    else this.#frame.showProblem(say("error.http"), () => location.reload());
    dropUnsentOf(this.#here.tokens.filter((_, person) => this.#here.views[person]?.step.kind === "code"));
  }

  /** @param {number[]} people @returns {Context} */
  #context(people) {
    const steps = this.#here.steps(people);
    const place = this.#here.places[people[0]];
    const two = this.#here.areTwo;
    const bothDone = two && this.#here.haveFinished;
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
      play: () => void this.#play(this.#here.steps(this.#here.turn)),
      addPerson: this.study.one_screen && !two ? () => this.#checkIn.askSecond() : null,
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
    this.#here.turnToOtherCode();
    this.#show();
  }

  /**
   * Asks for one person after the other, until each has an answer.
   * @param {number[]} people
   * @param {(place: Place, index: number) => Promise<View>} ask
   */
  async #each(people, ask) {
    const places = this.#here.places;
    const views = [...this.#here.views];
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
    const people = this.#here.whoCanStop;
    const places = this.#here.places;
    const stopped = await askToStop(people, this.#pay, async (person, keep) => {
      const view = await this.#persistence.until(() => places[person].stop(keep));
      if (places === this.#here.places) this.#here.views[person] = view;
    });
    if (stopped) await this.#takeAllOf(places, [...this.#here.views]);
  }

  // ---- language ---------------------------------------------------------------------------------------------

  /** @param {string} language */
  async #setLanguage(language) {
    keepLanguage(language);
    if (this.#checkIn.asksNext) return this.#checkIn.askNext(language);
    if (this.#here.places.length === 0) {
      await this.#follow(language);
      this.#checkIn.askWho("", recruitmentParameters(location.search)); // of a link that was refused
      return;
    }
    if (this.#here.views[0]?.step.kind === "ended-elsewhere") await this.#follow(language);
    const places = this.#here.places;
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
