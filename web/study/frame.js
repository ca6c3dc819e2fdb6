// @ts-check
/*
 * The frame around each screen of a study: title, progress, who is asked, the connection, language and Stop. A screen
 * is replaced only by another one, so that an update of the same step does not interrupt anybody.
 */

import { heading } from "../components/action.js";
import { byId, el } from "../core/dom.js";
import { currentLanguage, isolated, say } from "../text/catalogue.js";
import { languageName } from "../text/language.js";
import { isBusy } from "./persistence.js";
import { card } from "./screen.js";
import { titleOf } from "./service.js";

/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {import("./service.js").View} View */
/** @typedef {import("./service.js").Study} Study */

const NO_STOP = ["consent", "code", "ended-elsewhere"]; // the consent screen has "I do not agree"

export class StudyFrame {
  #screen = byId("study-screen", HTMLElement);
  #title = byId("study-title", HTMLElement);
  #part = byId("study-part", HTMLElement);
  #progress = byId("study-progress", HTMLProgressElement);
  #banner = byId("study-banner", HTMLElement);
  #who = byId("study-who", HTMLElement);
  #stop = byId("study-stop", HTMLElement);
  #language = byId("study-language", HTMLLabelElement);
  /** @type {Screen | null} */
  #shown = null;
  #id = "";
  #unseen = false; // the screen changed while the tab was hidden

  /** @param {{language: (language: string) => void, stop: () => void}} actions */
  constructor(actions) {
    this.actions = actions;
    document.addEventListener("visibilitychange", () => this.#showTitle());
  }

  /** @param {Study} study */
  setTexts(study) {
    this.#title.textContent = titleOf(study, currentLanguage());
    this.#progress.setAttribute("aria-label", say("study.page.title"));
    const stop = el(
      "button",
      { type: "button", class: "button-link", onclick: this.actions.stop },
      say("study.page.stop"),
    );
    this.#stop.replaceChildren(`${say("study.page.stopQuestion")} `, stop);
    this.#showLanguages(study.languages);
  }

  /** @param {readonly string[]} languages */
  #showLanguages(languages) {
    const select = el(
      "select",
      { class: "select language-select" },
      ...languages.map((language) => el("option", { value: language }, languageName(language))),
    );
    select.value = currentLanguage();
    select.addEventListener("change", () => this.actions.language(select.value));
    this.#language.replaceChildren(el("span", { class: "sr-only" }, say("study.page.language")), select);
    this.#language.hidden = languages.length < 2;
  }

  /**
   * @param {View | null} view
   * @param {readonly number[]} people whose screen it is
   * @param {boolean} several two people sit here
   */
  setPlace(view, people, several) {
    if (view && view.step.kind !== "ended-elsewhere") this.#title.textContent = isolated(view.study.title);
    this.#title.hidden = view === null; // the first screen has it as its heading
    const { done, total } = view?.position ?? { done: 0, total: 0 };
    this.#progress.hidden = total === 0;
    this.#progress.max = Math.max(1, total);
    this.#progress.value = done;
    this.#part.textContent = total > 0 ? say("study.page.progress", { done: Math.min(done + 1, total), total }) : "";
    this.#stop.hidden = !view?.can_stop || NO_STOP.includes(view.step.kind);
    this.#who.hidden = !several || people.length > 1;
    this.#who.textContent = several ? say("study.page.handOver", { number: (people[0] ?? 0) + 1 }) : "";
  }

  /** @param {import("../core/api.js").ApiError | null} problem why the server is asked again */
  setProblem(problem) {
    this.#banner.hidden = problem === null;
    if (problem) this.#banner.textContent = say(isBusy(problem) ? "study.page.busy" : "study.page.reconnecting");
  }

  /** @param {string} id */
  shows(id) {
    return this.#id === id;
  }

  /**
   * @param {string} id two screens with the same id are the same screen
   * @param {() => Screen} make
   * @param {import("./service.js").Step} [step] update for a screen that stays
   */
  show(id, make, step) {
    if (id === this.#id) {
      if (step) this.#shown?.update?.(step);
      return;
    }
    this.#shown?.close?.();
    this.#id = id;
    this.#shown = make();
    this.#screen.dataset.kind = step?.kind ?? "";
    this.#screen.dataset.key = id;
    this.#screen.replaceChildren(this.#shown.root);
    this.#unseen = document.hidden;
    this.#showTitle();
    scrollTo(0, 0);
    this.#screen.querySelector("h1")?.focus({ preventScroll: true });
  }

  /** A dot in the tab's title marks a screen that has not been seen yet. */
  #showTitle() {
    if (!document.hidden) this.#unseen = false;
    const h1 = this.#screen.querySelector("h1");
    const names = new Set([h1?.textContent, this.#title.textContent]); // the first screen is headed by the title itself
    document.title = (this.#unseen ? "● " : "") + [...names].filter(Boolean).join(" · ");
  }

  /** @param {string} sentence @param {() => void} again */
  showProblem(sentence, again) {
    const retry = () => {
      this.#id = "";
      again();
    };
    const button = el(
      "button",
      { type: "button", class: "button button-primary", onclick: retry },
      say("study.page.tryAgain"),
    );
    this.show(`problem ${sentence}`, () => ({
      root: card(
        heading(say("error.title")),
        el("p", { class: "lead", role: "alert" }, sentence),
        el("div", { class: "row" }, button),
      ),
    }));
  }
}
