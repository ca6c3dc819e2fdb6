// @ts-check
/*
 * The questions at the end of a game from the lobby, for one seat. They can be skipped.
 */

import { ApiError, requestJson } from "../core/api.js";
import { el, notice } from "../core/dom.js";
import { QuestionForm } from "../questionnaire/form.js";
import { givenAnswers } from "../questionnaire/pages.js";
import { currentLanguage, say, sayError } from "../text/catalogue.js";

/**
 * @typedef {object} Options
 * @property {string} room
 * @property {() => string} token  of the seat; asked for each request, since every new connection brings another one
 * @property {string} partnerName
 * @property {() => void} onDone
 * @property {() => void} onSkip
 */

/**
 * Shows the questionnaire in `container` and calls `onDone` when the last answer has reached the server.
 * @param {HTMLElement} container
 * @param {Options} options
 */
export async function showQuestionnaire(container, options) {
  const { room, token } = options;
  const path = `/api/rooms/${encodeURIComponent(room)}/answers`;
  try {
    const asked = `/api/questionnaire?language=${currentLanguage()}`;
    const [questionnaire, kept] = await Promise.all([requestJson(asked), requestJson(path, { token: token() })]);
    showForm(container, options, path, questionnaire, givenAnswers(kept.answers));
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    const retry = () => void showQuestionnaire(container, options);
    const again = el("button", { type: "button", class: "button", onclick: retry }, say("form.tryAgain"));
    container.replaceChildren(el("div", { class: "stack" }, notice("bad", sayError(error)), again));
  }
}

/**
 * @param {HTMLElement} container
 * @param {Options} options
 * @param {string} path where answers go
 * @param {{title: string, items: import("../questionnaire/pages.js").Item[]}} questionnaire
 * @param {Map<string, import("../questionnaire/pages.js").Given>} answers those already given
 */
function showForm(container, { token, partnerName, onDone, onSkip }, path, { title, items }, answers) {
  /** @param {() => void} onward */
  const leave = (onward) => {
    form.close();
    onward();
  };
  const form = new QuestionForm({
    title,
    about: partnerName,
    items,
    answers,
    showsProgress: true,
    send: async ({ question, value, text, elapsed_ms }) =>
      void (await requestJson(path, { token: token(), body: { question, value, text, elapsed_ms } })),
    onDone: () => leave(onDone),
  });
  const skip = el("button", { type: "button", class: "button-link", onclick: () => leave(onSkip) }, say("form.skip"));
  const stop = el("p", { class: "muted small questionnaire-leave" }, say("form.stopQuestion"), " ", skip);
  container.replaceChildren(el("div", { class: "questionnaire" }, form.root, stop));
  form.focus();
}
