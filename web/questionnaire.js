// @ts-check
/*
 * The questionnaire of one seat: three questions per page, every click saved at once, resumed after a reload.
 * What the pages hold is in questionnaire_pages.js, how answers reach the server in answer_queue.js.
 */

import { AnswerQueue } from "./core/answer_queue.js";
import { ApiError, requestJson } from "./core/api.js";
import { el, notice } from "./core/dom.js";
import {
  givenAnswers,
  missing,
  missingSentence,
  pageTitle,
  paginate,
  resumePage,
} from "./study/forms/questionnaire_pages.js";

/** @typedef {import("./study/forms/questionnaire_pages.js").Item} Item */
/** @typedef {import("./study/forms/questionnaire_pages.js").Given} Given */
/** @typedef {{room: string, token: string, partnerName: string, onDone: () => void}} Options */

const SCALE = [1, 2, 3, 4, 5, 6, 7];
const NO_ANSWER = -1;
const TEXT_LIMIT = 4000; // study/questionnaire.py
const TYPING_MS = 700; // a text is saved this long after the last key
const SAVED_AT_ONCE = "Every answer is saved at once";

/**
 * Shows the questionnaire in `container` and calls `onDone` when the last answer has reached the server.
 * @param {HTMLElement} container
 * @param {Options} options
 */
export async function showQuestionnaire(container, options) {
  try {
    const path = `/api/rooms/${encodeURIComponent(options.room)}/answers`;
    const [questionnaire, kept] = await Promise.all([
      requestJson("/api/questionnaire"),
      requestJson(path, { token: options.token }),
    ]);
    new Form(container, path, options, questionnaire, givenAnswers(kept.answers)).show();
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    const again = el(
      "button",
      { type: "button", class: "button", onclick: () => void showQuestionnaire(container, options) },
      "Try again",
    );
    container.replaceChildren(el("div", { class: "stack" }, notice("bad", error.message), again));
  }
}

class Form {
  /**
   * @param {HTMLElement} container
   * @param {string} path where answers go
   * @param {Options} options
   * @param {{title: string, items: Item[]}} questionnaire
   * @param {Map<string, Given>} answers those already given
   */
  constructor(container, path, options, questionnaire, answers) {
    this.container = container;
    this.options = options;
    this.title = questionnaire.title;
    this.pages = paginate(questionnaire.items);
    this.answers = answers;
    this.page = resumePage(this.pages, answers);
    this.shownAt = performance.now();
    /** @type {(() => void) | null} saves a text that is still being typed */
    this.flushText = null;
    this.queue = new AnswerQueue(
      async (answer) => void (await requestJson(path, { token: options.token, body: answer })),
      () => this.showSaving(),
    );
    this.online = () => this.queue.retryNow();
    window.addEventListener("online", this.online);
  }

  show() {
    this.shownAt = performance.now();
    const items = this.pages[this.page];
    this.heading = el("h1", { tabindex: "-1" }, this.title); // it stands alone on its page
    this.problem = el("div", { role: "alert" });
    this.status = el("p", { class: "muted small questionnaire-status", role: "status" });
    this.bar = el("progress", { class: "bar", max: this.pages.flat().length, "aria-label": "Questions answered" });
    const form = el(
      "form",
      { class: "card card-roomy questionnaire-page", novalidate: true },
      this.problem,
      ...items.map((item) => (item.kind === "text" ? this.textQuestion(item) : this.scaleQuestion(item))),
      this.footer(),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.next();
    });
    const stop = el(
      "button",
      { type: "button", class: "button-link", onclick: () => void this.leave() },
      "Skip the questions",
    );
    const leave = el("p", { class: "muted small questionnaire-leave" }, "Want to stop? ", stop);
    this.container.replaceChildren(el("div", { class: "questionnaire" }, this.header(), form, leave));
    this.showSaving();
    this.heading.focus({ preventScroll: true });
    this.container.scrollIntoView({ block: "start" });
  }

  header() {
    const where = `${this.options.partnerName} · ${pageTitle(this.pages, this.page).toLowerCase()}`;
    return el("header", { class: "questionnaire-head" }, this.heading, el("p", { class: "muted" }, where), this.bar);
  }

  footer() {
    const last = this.page === this.pages.length - 1;
    const back = el(
      "button",
      { type: "button", class: "button", disabled: this.page === 0, onclick: () => this.turn(-1) },
      "Back",
    );
    this.nextButton = el("button", { type: "submit", class: "button button-primary" }, last ? "Finish" : "Next");
    return el("div", { class: "row row-apart questionnaire-foot" }, back, this.status, this.nextButton);
  }

  /** @param {Item} item */
  scaleQuestion(item) {
    const given = this.answers.get(item.id)?.value;
    const boxes = SCALE.map((value) => this.radio(item, value, given));
    const id = `question-${item.id}`;
    const ends = el(
      "div",
      { class: "likert-ends" },
      el("span", { id: `${id}-low` }, "strongly disagree"),
      this.radio(item, NO_ANSWER, given),
      el("span", { id: `${id}-high` }, "strongly agree"),
    );
    return el(
      "fieldset",
      { class: "question", id, "aria-describedby": `${id}-missing` },
      el("legend", {}, item.text),
      el("div", { class: "likert" }, ...boxes),
      ends,
      el("p", { class: "question-missing", id: `${id}-missing` }, "Please choose one."),
    );
  }

  /** @param {Item} item @param {number} value @param {number | undefined} given */
  radio(item, value, given) {
    const end = value === SCALE[0] ? "low" : value === SCALE.at(-1) ? "high" : null;
    const describedBy = end && `question-${item.id}-${end}`;
    const props = { type: "radio", name: item.id, value, checked: given === value, "aria-describedby": describedBy };
    const input = el("input", props);
    input.addEventListener("change", () => this.save(item.id, value, ""));
    return value === NO_ANSWER
      ? el("label", { class: "no-answer" }, input, el("span", {}, "I prefer not to answer"))
      : el("label", { class: "likert-option" }, input, el("span", {}, String(value)));
  }

  /** @param {Item} item */
  textQuestion(item) {
    const id = `question-${item.id}`;
    const area = el("textarea", {
      id,
      class: "input",
      rows: 6,
      maxlength: TEXT_LIMIT,
      "aria-describedby": `${id}-help`,
    });
    area.value = this.answers.get(item.id)?.text ?? "";
    const flush = () => {
      window.clearTimeout(timer);
      this.flushText = null;
      if (area.value !== (this.answers.get(item.id)?.text ?? "")) this.save(item.id, NO_ANSWER, area.value);
    };
    let timer = 0;
    area.addEventListener("input", () => {
      window.clearTimeout(timer);
      timer = window.setTimeout(flush, TYPING_MS);
      this.flushText = flush;
    });
    area.addEventListener("change", flush);
    const help = el(
      "p",
      { id: `${id}-help`, class: "field-help" },
      "In your own words, as much or as little as you like. You may leave it empty.",
    );
    return el("div", { class: "field question" }, el("label", { for: id }, item.text), help, area);
  }

  /** @param {string} question @param {number} value @param {string} text */
  save(question, value, text) {
    this.answers.set(question, { value, text });
    document.getElementById(`question-${question}`)?.removeAttribute("data-missing");
    this.queue.add({ question, value, text, elapsed_ms: Math.round(performance.now() - this.shownAt) });
  }

  showSaving() {
    if (!this.status || !this.bar) return; // nothing on the page yet
    const { waiting, offline, refused } = this.queue.state;
    this.status.textContent =
      refused ||
      (offline && waiting ? "No connection. Your answers wait here and are sent when it is back." : SAVED_AT_ONCE);
    this.status.dataset.waiting = String(waiting);
    this.bar.value = this.answers.size;
  }

  /** @param {number} step */
  turn(step) {
    this.flushText?.();
    this.page += step;
    this.show();
  }

  async next() {
    const open = missing(this.pages[this.page], this.answers);
    if (open.length > 0) return this.complain(open);
    if (this.page < this.pages.length - 1) return this.turn(1);
    this.flushText?.();
    if (this.nextButton) this.nextButton.disabled = true;
    await this.queue.settled();
    if (this.queue.state.refused) {
      if (this.nextButton) this.nextButton.disabled = false;
      return;
    }
    this.done();
  }

  /** What is answered stays; what is on its way goes on in the background. */
  async leave() {
    this.flushText?.();
    this.done();
    await this.queue.settled();
  }

  done() {
    window.removeEventListener("online", this.online);
    this.options.onDone();
  }

  /** Names what is missing, and takes the keyboard to the first of it. @param {Item[]} open */
  complain(open) {
    this.problem?.replaceChildren(notice("bad", missingSentence(open.length)));
    for (const item of open) document.getElementById(`question-${item.id}`)?.setAttribute("data-missing", "");
    const first = document.querySelector(`#question-${CSS.escape(open[0].id)} input`);
    if (first instanceof HTMLInputElement) first.focus();
  }
}
