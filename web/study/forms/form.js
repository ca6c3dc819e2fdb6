// @ts-check
/*
 * A form or questionnaire of a study: three questions per page, every click saved at once, resumed after a reload
 * and after a time without connection. The widgets are in study_questions.js.
 */

import { AnswerQueue } from "../../core/answer_queue.js";
import { el } from "../../core/dom.js";
import { missing, paginate, resumePage } from "./questionnaire_pages.js";
import { attempt, complain, heading, problemBox } from "../screen.js";
import { say } from "../../text/catalogue.js";
import { idOf, question } from "./questions.js";
import { UnsentAnswers } from "./unsent_answers.js";

/** @typedef {import("../screen.js").Context} Context */
/** @typedef {import("../screen.js").Screen} Screen */
/** @typedef {import("../service.js").Item} Item */
/** @typedef {import("./questionnaire_pages.js").Given} Given */

/** @param {Context} context @returns {Screen} */
export function formScreen(context) {
  return new Form(context);
}

class Form {
  root = el("div", { class: "questionnaire" });
  /** @type {import("./questions.js").Question[]} */
  #questions = [];
  #status = el("p", { class: "muted small questionnaire-status", role: "status" });
  #problem = problemBox();
  #watch = new Stopwatch();
  #online = () => this.#queue.retryNow();
  /** @type {AnswerQueue} */
  #queue;

  /** @param {Context} context */
  constructor(context) {
    const { step, place } = context;
    this.context = context;
    this.pages = paginate(step.items ?? []);
    /** @type {Map<string, Given>} */
    this.answers = new Map(Object.entries(step.answers ?? {}));
    this.unsent = new UnsentAnswers(`${place.token.slice(0, 12)} ${step.key}`);
    this.#queue = new AnswerQueue(
      async (answer) => {
        await place.answer(step.key, answer);
        this.unsent.remove(answer);
      },
      () => this.#showSaving(),
    );
    for (const answer of this.unsent.all()) {
      this.answers.set(answer.question, answer);
      this.#queue.add(answer);
    }
    this.page = resumePage(this.pages, this.answers);
    window.addEventListener("online", this.#online);
    this.#draw();
  }

  close() {
    for (const { flush } of this.#questions) flush();
    window.removeEventListener("online", this.#online);
    this.#watch.stop();
  }

  #draw() {
    this.#watch.restart();
    this.#problem.replaceChildren();
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
    const { step } = this.context;
    const before = this.pages.slice(0, this.page).flat().length;
    const count = this.pages[this.page].length;
    const total = this.pages.flat().length;
    const where = say(count === 1 ? "form.where.one" : "form.where.many", {
      first: before + 1,
      last: before + count,
      total,
    });
    const partner = step.partner_letter ? `${say("form.partner", { letter: step.partner_letter })} · ` : "";
    return heading(step.title ?? "", partner + where);
  }

  #footer() {
    const last = this.page === this.pages.length - 1;
    const back = el(
      "button",
      { type: "button", class: "button", onclick: () => this.#turn(-1) },
      say("study.page.back"),
    );
    if (this.page === 0) back.classList.add("invisible");
    this.nextButton = el(
      "button",
      { type: "submit", class: "button button-primary" },
      say(last ? "form.finish" : "study.page.next"),
    );
    return el("div", { class: "row row-apart questionnaire-foot" }, back, this.#status, this.nextButton);
  }

  /** @param {Item} item @param {number} value @param {string} text */
  #save(item, value, text) {
    this.answers.set(item.id, { value, text });
    document.getElementById(idOf(item))?.removeAttribute("data-missing");
    const answer = { question: item.id, value, text, ...this.#watch.read() };
    this.unsent.add(answer);
    this.#queue.add(answer);
  }

  #showSaving() {
    const { waiting, offline, refused } = this.#queue.state;
    this.#status.textContent = refused || say(offline && waiting ? "form.unsaved" : "form.saved");
    this.#status.dataset.waiting = String(waiting);
  }

  /** @param {number} step */
  #turn(step) {
    for (const { flush } of this.#questions) flush();
    this.page += step;
    this.#draw();
    this.root.querySelector("h1")?.focus({ preventScroll: true });
    this.root.scrollIntoView({ block: "start" });
  }

  async #next() {
    for (const { flush } of this.#questions) flush();
    const open = missing(this.pages[this.page], this.answers);
    if (open.length > 0) return this.#complain(open);
    if (this.page < this.pages.length - 1) return this.#turn(1);
    if (this.nextButton) await attempt(this.nextButton, this.#problem, () => this.#finish());
  }

  /** The last answer has arrived before the step is left. */
  async #finish() {
    await this.#queue.settled();
    if (!this.#queue.state.refused) await this.context.next();
  }

  /** Names what is missing, and takes the keyboard to the first of it. @param {Item[]} open */
  #complain(open) {
    complain(this.#problem, say(open.length === 1 ? "form.missingOne" : "form.missingMany", { count: open.length }));
    for (const item of open) document.getElementById(idOf(item))?.setAttribute("data-missing", "");
    const first = document.querySelector(`#${CSS.escape(idOf(open[0]))} :is(input, textarea)`);
    if (first instanceof HTMLElement) first.focus();
  }
}

/** How long a page is shown, and how long of it nobody could see it. */
class Stopwatch {
  #start = performance.now();
  #hidden = 0;
  #hiddenSince = NaN;
  #listen = () => this.#visibility();

  constructor() {
    document.addEventListener("visibilitychange", this.#listen);
    this.#visibility();
  }

  restart() {
    this.#start = performance.now();
    this.#hidden = 0;
    if (document.hidden) this.#hiddenSince = this.#start;
  }

  stop() {
    document.removeEventListener("visibilitychange", this.#listen);
  }

  read() {
    const now = performance.now();
    const running = document.hidden ? now - this.#hiddenSince : 0;
    return { elapsed_ms: Math.round(now - this.#start), hidden_ms: Math.round(this.#hidden + running) };
  }

  #visibility() {
    const now = performance.now();
    if (document.hidden) this.#hiddenSince = now;
    else if (!Number.isNaN(this.#hiddenSince)) {
      this.#hidden += now - this.#hiddenSince;
      this.#hiddenSince = NaN;
    }
  }
}
