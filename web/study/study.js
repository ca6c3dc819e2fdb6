// @ts-check
/*
 * Starts the study page: chooses the language, asks the server for the study, or says why there is none.
 */

import { heading } from "../components/action.js";
import { requireStorage } from "../core/browser_storage.js";
import { byId, el } from "../core/dom.js";
import { readLayout } from "../input/keyboard_layout.js";
import { currentLanguage, say, sayError, useLanguage } from "../text/catalogue.js";
import { LANGUAGES, hasWords, pickLanguage, wishedLanguages } from "../text/language.js";
import { Persistence } from "./persistence.js";
import { card } from "./screen.js";
import { askStudy } from "./service.js";
import { StudyPage } from "./study_page.js";

async function boot() {
  const banner = byId("study-banner", HTMLElement);
  const persistence = new Persistence((problem) => (banner.hidden = problem === null));
  const wished = wishedLanguages();
  const first = pickLanguage(Object.keys(LANGUAGES), wished);
  await Promise.all([persistence.until(() => useLanguage(first)), readLayout()]);
  try {
    requireStorage();
    const study = await persistence.until(askStudy);
    const language = pickLanguage(study.languages.filter(hasWords), wished);
    if (language !== undefined && language !== currentLanguage()) await persistence.until(() => useLanguage(language));
    await new StudyPage(study).start();
  } catch (error) {
    showBootProblem(error);
  }
}

/** The only screen when the study cannot be loaded. @param {unknown} error */
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
