// @ts-check
/*
 * The study page: whoever sits here, the screen of their step, and the way to the game and back. The server decides
 * what comes; every screen is a module of its own. Nothing is kept here but the tokens, so a reload is harmless.
 */

import { heading } from "../components/action.js";
import { ApiError } from "../core/api.js";
import { byId, el } from "../core/dom.js";
import { LiveStream } from "../core/live_stream.js";
import { saveTokens } from "../wire/seat_tokens.js";
import { arrivalScreen, recruitmentParameters } from "./arrival.js";
import { consentScreen } from "./consent.js";
import { codeScreen, debriefScreen } from "./ending.js";
import { formScreen } from "./form_screen.js";
import { StudyFrame } from "./frame.js";
import { inputCheckScreen } from "./input_check/input_check.js";
import { markStudyRound } from "../text/study_mark.js";
import { breakScreen, elsewhereScreen, pausedScreen, waitingScreen } from "./pauses.js";
import { loadPeople, savePeople, seatsToTake, whoseTurn } from "./people.js";
import { Persistence } from "./persistence.js";
import { roundName, roundScreen } from "./round.js";
import { card } from "./screen.js";
import { Place, arrive, askStudy } from "./service.js";
import { askToStop } from "./stop.js";
import { LANGUAGES, keepLanguage, pickLanguage, wishedLanguages } from "../text/language.js";
import { currentLanguage, say, sayError, useLanguage } from "../text/catalogue.js";

/** @typedef {import("./service.js").View} View */
/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */

const POLL_MS = 10_000;
const POLL_PLAYING_MS = 2000; // somebody is just coming back from the game
const CLOCK_MS = 1000;

const SCREENS = /** @type {Record<string, (context: Context) => Screen>} */ ({
  consent: consentScreen,
  form: formScreen,
  questionnaire: formScreen,
  "input-check": inputCheckScreen,
  practice: roundScreen,
  round: roundScreen,
  waiting: waitingScreen,
  break: breakScreen,
  paused: pausedScreen,
  debrief: debriefScreen,
  code: codeScreen,
  "ended-elsewhere": elsewhereScreen,
});

class StudyPage {
  #persistence = new Persistence((offline) => this.#frame.setOffline(offline));
  /** @type {Place[]} */
  #places = [];
  /** @type {View[]} */
  #views = [];
  /** @type {LiveStream[]} */
  #streams = [];
  #newsAtMs = 0;
  #asking = false;
  #readyFor = ""; // the round that somebody here has said to be ready for
  #codeOf = 0;
  #frame = new StudyFrame({ language: (language) => void this.#setLanguage(language), stop: () => void this.#stop() });

  /** @param {import("./service.js").Study} study */
  constructor(study) {
    this.study = study;
  }

  async start() {
    this.#frame.setTexts(this.study);
    setInterval(() => this.#tick(), CLOCK_MS);
    addEventListener("pageshow", (event) => event.persisted && location.reload()); // back from the game: all is old
    const parameters = recruitmentParameters(location.search);
    if (Object.keys(parameters).length > 0) return this.#arriveByLink(parameters);
    const tokens = loadPeople();
    if (tokens.length === 0) return this.#askWho("");
    this.#places = tokens.map((token) => new Place(token));
    await this.#refresh();
    this.#listen();
  }

  // ---- arriving ---------------------------------------------------------------------------------------------

  /** @param {Record<string, string>} parameters */
  async #arriveByLink(parameters) {
    try {
      await this.#arrive(parameters);
    } catch (error) {
      this.#askWho(sayError(error), parameters);
    }
  }

  /** @param {Record<string, string>} parameters @param {boolean} [second] beside the first person */
  async #arrive(parameters, second = false) {
    const beside = second ? this.#places[0]?.token : undefined;
    const { token, view } = await this.#persistence.until(() => arrive(parameters, currentLanguage(), beside));
    this.#places = second ? [this.#places[0], new Place(token)] : [new Place(token)];
    this.#views = second ? [this.#views[0], view] : [view];
    savePeople(this.#places.map((place) => place.token));
    history.replaceState(null, "", location.pathname); // ids do not stay in the address
    await this.#follow(view.language);
    this.#listen();
    this.#show();
  }

  /**
   * @param {string} problem why we ask (again); empty: for the first time
   * @param {Record<string, string>} [given] by the link
   */
  #askWho(problem, given = {}) {
    this.#forget();
    const options = {
      title: this.study.title,
      asksCode: this.study.asks_code,
      second: false,
      problem,
      given,
      cancel: null,
    };
    this.#frame.show(`arrival ${problem} ${currentLanguage()}`, () =>
      arrivalScreen({ ...options, arrive: (parameters) => this.#arrive(parameters) }),
    );
  }

  #askSecond() {
    const options = {
      title: this.study.title,
      asksCode: this.study.asks_code,
      second: true,
      problem: "",
      given: {},
      cancel: () => this.#show(),
    };
    this.#frame.show("arrival-2", () =>
      arrivalScreen({ ...options, arrive: (parameters) => this.#arrive(parameters, true) }),
    );
  }

  #forget() {
    for (const stream of this.#streams) stream.close();
    this.#streams = [];
    this.#places = [];
    this.#views = [];
    this.#codeOf = 0;
    savePeople([]);
    this.#frame.setPlace(null, [], false);
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
    if (performance.now() - this.#newsAtMs > (playing ? POLL_PLAYING_MS : POLL_MS)) void this.#refresh();
  }

  async #refresh() {
    if (this.#asking || this.#places.length === 0) return;
    this.#asking = true;
    this.#newsAtMs = performance.now();
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
    if (error instanceof ApiError && (error.status === 401 || error.status === 404)) this.#askWho(sentence);
    else this.#frame.showProblem(sentence, () => void this.#refresh());
  }

  /** @param {number} person @param {View} view */
  async #take(person, view) {
    await this.#takeAll(this.#places.map((_, index) => (index === person ? view : this.#views[index])).filter(Boolean));
  }

  /** @param {View[]} views */
  async #takeAll(views) {
    if (views.length < this.#places.length) return; // the other person's is on its way
    this.#views = views;
    this.#newsAtMs = performance.now();
    await this.#follow(views[0].language);
    this.#show();
  }

  // ---- what is shown ----------------------------------------------------------------------------------------

  #show() {
    const people = this.#turn();
    const steps = people.map((person) => this.#views[person].step);
    const [step] = steps;
    this.#frame.setPlace(this.#views[people[0]], people, this.#places.length > 1);
    if (this.#frame.shows("arrival-2") && step.kind !== "ended-elsewhere" && this.#places.length < 2) return;
    if (step.state === "card" || step.state === "waiting") this.#readyFor = step.key;
    if (step.state === "playing" && step.key === this.#readyFor && this.#play(steps)) return;
    const make = SCREENS[step.kind];
    const id = JSON.stringify([
      people,
      step.key,
      step.kind,
      step.state,
      Boolean(step.room),
      step.version,
      currentLanguage(),
    ]);
    if (make) this.#frame.show(id, () => make(this.#context(people)), step);
    else this.#frame.showProblem(say("error.http"), () => location.reload());
  }

  #turn() {
    const people = whoseTurn(this.#views);
    const finished = this.#views.every(({ step }) => step.kind === "code");
    return finished && this.#views.length > 1 ? [this.#codeOf] : people;
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
      steps,
      people,
      place,
      several: two,
      next: (given) => this.#each(people, (one) => one.next(key, given)),
      decline: () => this.#each(people, (one) => one.decline()),
      play: () => void this.#play(this.#turn().map((person) => this.#views[person].step)),
      addPerson: this.study.group === 2 && !two ? () => this.#askSecond() : null,
      leaveScreen: () => this.#askWho(""),
      nextCode: bothDone ? () => this.#otherCode() : null,
      refresh: () => performance.now() - this.#newsAtMs > POLL_PLAYING_MS && void this.#refresh(),
    };
  }

  #otherCode() {
    this.#codeOf = 1 - this.#codeOf;
    this.#show();
  }

  /**
   * One after the other, until each was answered.
   * @param {number[]} people
   * @param {(place: Place) => Promise<View>} ask
   */
  async #each(people, ask) {
    const views = [...this.#views];
    for (const person of people) views[person] = await this.#persistence.until(() => ask(this.#places[person]));
    await this.#takeAll(views);
  }

  /** Goes to the room, when every seat of this screen is known. @param {import("./service.js").Step[]} steps */
  #play(steps) {
    const seats = seatsToTake(steps);
    if (seats === null) return false;
    saveTokens(seats.id, seats.tokens);
    const [{ key, kind }] = steps;
    const language = currentLanguage();
    markStudyRound({
      room: seats.id,
      key,
      practice: kind === "practice",
      language,
      name: roundName(steps[0]),
    });
    location.assign(seats.path);
    return true;
  }

  async #stop() {
    const people = this.#turn();
    const stopped = await askToStop(people, async (person, keep) => {
      this.#views[person] = await this.#persistence.until(() => this.#places[person].stop(keep));
    });
    if (stopped) await this.#takeAll([...this.#views]);
  }

  // ---- language ---------------------------------------------------------------------------------------------

  /** @param {string} language */
  async #setLanguage(language) {
    keepLanguage(language);
    if (this.#places.length === 0) {
      await this.#follow(language);
      this.#askWho("");
      return;
    }
    await this.#takeAll(
      await this.#persistence.until(() => Promise.all(this.#places.map((place) => place.view(language)))),
    );
  }

  /** Turns to the language of the study's texts, or to the nearest that there is. @param {string} language */
  async #follow(language) {
    const wanted = pickLanguage(Object.keys(LANGUAGES), [language]);
    if (wanted === currentLanguage()) return;
    await this.#persistence.until(() => useLanguage(wanted));
    this.#frame.setTexts(this.study);
  }
}

async function boot() {
  const banner = byId("study-banner", HTMLElement);
  const persistence = new Persistence((offline) => (banner.hidden = !offline));
  const known = Object.keys(LANGUAGES);
  const wished = wishedLanguages();
  await persistence.until(() => useLanguage(pickLanguage(known, wished)));
  try {
    const study = await persistence.until(askStudy);
    const offered = study.languages.filter((language) => known.includes(language));
    if (offered.length > 0 && !offered.includes(currentLanguage()))
      await persistence.until(() => useLanguage(pickLanguage(offered, wished)));
    await new StudyPage(study).start();
  } catch (error) {
    showBootProblem(error);
  }
}

/** Nothing can be shown yet but what went wrong. @param {unknown} error */
function showBootProblem(error) {
  const again = el(
    "button",
    { type: "button", class: "button button-primary", onclick: () => location.reload() },
    say("study.page.tryAgain"),
  );
  const sentence = el("p", { class: "lead", role: "alert" }, sayError(error));
  byId("study-screen", HTMLElement).replaceChildren(
    card(heading(say("error.title")), sentence, el("div", { class: "row" }, again)),
  );
}

void boot();
