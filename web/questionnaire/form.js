// @ts-check
/*
 * A questionnaire, wherever it is asked: pages of questions, every answer saved as it is given, resumed after a reload
 * and after a lost connection. What comes before and after, and where answers go, is the caller's.
 */

import { heading, problemBox, runAction, showProblem } from "../components/action.js";
import { ApiError } from "../core/api.js";
import { el } from "../core/dom.js";
import { say, sayError } from "../text/catalogue.js";
import { AnswerQueue } from "./answer_queue.js";
import { PageTimer } from "./page_timer.js";
import { missing, paginate, positionOf, resumePage } from "./pages.js";
import { question } from "./questions.js";
import { idOf } from "./radio.js";

/** @typedef {import("./pages.js").Item} Item */
/** @typedef {import("./pages.js").Given} Given */
/** @typedef {import("./answer_queue.js").Answer} Answer */
/**
 * @typedef {object} Options
 * @property {string} title
 * @property {string} about whom or what the questions are about, above the title; may be empty
 * @property {readonly Item[]} items
 * @property {Map<string, Given>} answers those already given
 * @property {(answer: Answer) => Promise<void>} send saves one answer; see AnswerQueue
 * @property {() => Promise<void> | void} onDone every page is answered and saved
 * @property {boolean} [showsProgress] whether a bar counts the answered questions
 * @property {import("./unsent_answers.js").UnsentAnswers} [unsent] keeps answers through a closed tab
 * @property {{page?: number}} [kept] the page that is shown, for the same form in another language
 */

const UNFIT = 422; // the status of an answer that the server will never take

export class QuestionForm {
  root = el("div", { class: "questionnaire" });
  /** @type {import("./questions.js").Question[]} */
  #questions = [];
  #status = el("p", { class: "muted small questionnaire-status", role: "status" });
  #problem = problemBox();
  #missingCount = 0; // as last complained about
  #timer = new PageTimer();
  #online = () => this.#queue.retryNow();
  #queue;
  /** @type {Set<string>} questions whose text the server did not take */
  #refused = new Set();
  /** @type {HTMLProgressElement | null} */
  #bar = null;

  /** @param {Options} options */
  constructor(options) {
    this.options = options;
    this.answers = options.answers;
    this.pages = paginate(options.items);
    this.#queue = new AnswerQueue(
      (answer) => this.#send(answer),
      () => this.#showSaving(),
    );
    if (options.showsProgress) this.#bar = progressBar(options.items.length);
    for (const answer of options.unsent?.all() ?? []) {
      this.answers.set(answer.question, answer);
      this.#queue.add(answer);
    }
    for (const answer of options.unsent?.refused() ?? []) {
      this.answers.set(answer.question, answer);
      this.#refused.add(answer.question);
    }
    this.kept = options.kept ?? {};
    this.page = this.kept.page ?? resumePage(this.pages, this.answers);
    window.addEventListener("online", this.#online);
    this.#draw();
  }

  /** The form goes away. What is being typed is saved; what is on its way still arrives. */
  close() {
    this.#flush();
    window.removeEventListener("online", this.#online);
    this.#timer.stop();
  }

  /** Takes the keyboard and the eye to the top of the page. */
  focus() {
    this.root.querySelector("h1")?.focus({ preventScroll: true });
    this.root.scrollIntoView({ block: "start" });
  }

  #draw() {
    this.kept.page = this.page;
    this.#timer.restart();
    this.#missingCount = 0;
    const refused = this.pages[this.page].some(({ id }) => this.#refused.has(id));
    showProblem(this.#problem, refused ? say("error.answer") : "");
    this.#questions = this.pages[this.page].map((item) =>
      question(item, this.answers.get(item.id), (...answer) => this.#save(...answer)),
    );
    const form = el(
      "form",
      { class: "card card-roomy questionnaire-page", novalidate: true },
      this.#problem,
      ...this.#questions.map(({ root }) => root),
      this.#footer(),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#next();
    });
    this.root.replaceChildren(this.#header(), form);
    this.#showSaving();
  }

  #header() {
    const { title, about } = this.options;
    const position = say("form.position", positionOf(this.pages, this.page));
    const head = heading(title, about ? `${about} · ${position}` : position);
    if (this.#bar) head.append(this.#bar);
    return head;
  }

  #footer() {
    const last = this.page === this.pages.length - 1;
    const back = el("button", { type: "button", class: "button", onclick: () => this.#turn(-1) }, say("form.back"));
    if (this.page === 0) back.classList.add("invisible");
    const next = say(last ? "form.finish" : "form.next");
    const kind = { type: "submit", class: "button button-primary", onclick: onlyWhileShown };
    this.nextButton = el("button", kind, next);
    return el("div", { class: "row row-apart questionnaire-foot" }, back, this.#status, this.nextButton);
  }

  /** What is refused for good is not sent again when the form is opened again. @param {Answer} answer */
  async #send(answer) {
    const { send, unsent } = this.options;
    try {
      await send(answer);
      unsent?.remove(answer);
    } catch (error) {
      if (error instanceof ApiError && error.code === "step") {
        unsent?.remove(answer); // no longer asked: there is nothing to mend
      } else if (error instanceof ApiError && error.status === UNFIT) {
        unsent?.refuse(answer);
        if (answer.text) this.#refused.add(answer.question);
      }
      throw error;
    }
  }

  /** @param {Item} item @param {number} value @param {string} text */
  #save(item, value, text) {
    this.answers.set(item.id, { value, text });
    this.#refused.delete(item.id);
    const answer = { question: item.id, value, text, ...this.#timer.read() };
    this.options.unsent?.add(answer);
    this.#queue.add(answer);
    if (this.#missingCount > 0) this.#showMissing();
  }

  #showSaving() {
    const { state } = this.#queue;
    this.#status.textContent = savingWords(state);
    this.#status.dataset.waiting = String(state.waiting);
    if (this.#bar) this.#bar.value = this.answers.size;
  }

  #flush() {
    for (const { flush } of this.#questions) flush();
  }

  /** @param {number} step */
  #turn(step) {
    this.#flush();
    this.page += step;
    this.#draw();
    this.focus();
  }

  async #next() {
    this.#flush();
    const [first] = this.#showMissing();
    if (first) return this.#focusQuestion(first);
    if (this.page < this.pages.length - 1) return this.#turn(1);
    if (this.nextButton) await runAction(this.nextButton, this.#problem, () => this.#finish());
  }

  /** The last answer has arrived before the form is left. */
  async #finish() {
    await this.#queue.settled();
    const toMend = this.pages.findIndex((page) => page.some(({ id }) => this.#refused.has(id)));
    if (toMend >= 0) return this.#turn(toMend - this.page);
    const { refused } = this.#queue.state;
    const isAsked = !(refused instanceof ApiError && refused.code === "step"); // else there is nothing to mend
    if (refused && isAsked) showProblem(this.#problem, savingWords(this.#queue.state));
    else await this.options.onDone();
  }

  /** Says how many answers are missing, and marks their questions; after a complaint again with each answer. */
  #showMissing() {
    const page = this.pages[this.page];
    const open = missing(page, this.answers);
    if (open.length !== this.#missingCount) {
      showProblem(this.#problem, open.length > 0 ? say("form.missing", { count: open.length }) : "");
    }
    this.#missingCount = open.length;
    for (const item of page) {
      document.getElementById(idOf(item))?.toggleAttribute("data-missing", open.includes(item));
    }
    return open;
  }

  /** @param {Item} item */
  #focusQuestion(item) {
    const input = this.root.querySelector(`#${CSS.escape(idOf(item))} :is(input, textarea)`);
    if (input instanceof HTMLElement) input.focus();
  }
}

/**
 * What becomes of the answers.
 * @param {import("./answer_queue.js").SaveState} state
 */
export function savingWords({ waiting, failure, refused }) {
  if (refused instanceof ApiError) return sayError(refused);
  if (refused !== null) return say("error.fault"); // of this page; no sentence of a browser is for people
  if (waiting === 0 || failure === null) return say("form.saved");
  return say(failure instanceof ApiError && failure.status > 0 ? "form.waiting" : "form.unsaved");
}

/** A second click in the same task finds its page gone; the browser would complain of it. @param {Event} event */
function onlyWhileShown(event) {
  if (event.currentTarget instanceof Node && !event.currentTarget.isConnected) event.preventDefault();
}

/** @param {number} most */
function progressBar(most) {
  return el("progress", { class: "bar", max: most, "aria-label": say("form.progress") });
}
