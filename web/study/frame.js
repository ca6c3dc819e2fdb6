// @ts-check
/*
 * What stands around each screen of a study: title and progress, who is asked, the connection, language and Stop.
 * Replaces a screen only when it is another one, so that news of the same step disturb nobody.
 */

import { heading } from "../components/action.js";
import { byId, el } from "../core/dom.js";
import { currentLanguage, say } from "../text/catalogue.js";
import { LANGUAGES } from "../text/language.js";
import { card } from "./screen.js";

/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {import("./service.js").View} View */
/** @typedef {import("./service.js").Study} Study */

const NO_STOP = ["consent", "code", "ended-elsewhere"]; // "I do not agree" is the consent's own; the others are over

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
  #unseen = false; // the screen came while nobody could see it

  /** @param {{language: (language: string) => void, stop: () => void}} actions */
  constructor(actions) {
    this.actions = actions;
    document.addEventListener("visibilitychange", () => this.#showTitle());
  }

  /** @param {Study} study */
  setTexts(study) {
    this.#title.textContent = study.title;
    this.#banner.textContent = say("study.page.reconnecting");
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
      ...languages.map((language) => el("option", { value: language }, LANGUAGES[language] ?? language)),
    );
    select.value = currentLanguage();
    select.addEventListener("change", () => this.actions.language(select.value));
    this.#language.replaceChildren(el("span", { class: "sr-only" }, say("study.page.language")), select);
    this.#language.hidden = languages.length < 2;
  }

  /**
   * @param {View | null} view
   * @param {readonly number[]} people whose screen it is
   * @param {boolean} several two sit here
   */
  setPlace(view, people, several) {
    if (view) this.#title.textContent = view.study.title;
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

  /** @param {boolean} offline */
  setOffline(offline) {
    this.#banner.hidden = !offline;
  }

  /** @param {string} id */
  shows(id) {
    return this.#id === id;
  }

  /**
   * @param {string} id what makes this screen another one
   * @param {() => Screen} make
   * @param {import("./service.js").Step} [step] news for a screen that stays
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

  /** In the tab's title a dot says that something new is there for who looks elsewhere. */
  #showTitle() {
    if (!document.hidden) this.#unseen = false;
    const h1 = this.#screen.querySelector("h1");
    document.title = `${this.#unseen ? "● " : ""}${h1?.textContent ?? ""} · ${this.#title.textContent}`;
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
