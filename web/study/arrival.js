// @ts-check
/*
 * The first screen: nobody knows yet who sits here. Asks for a code where the study wants one.
 */

import { heading, problemBox, runAction, showProblem } from "../components/action.js";
import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { card } from "./screen.js";

/** @typedef {import("./screen.js").Screen} Screen */

const PARAMETERS = [
  "PROLIFIC_PID",
  "STUDY_ID",
  "SESSION_ID",
  "assignmentId",
  "workerId",
  "hitId",
  "turkSubmitTo",
  "code",
];

/**
 * What a recruitment platform put into the link.
 * @param {string} query "?PROLIFIC_PID=…"
 * @returns {Record<string, string>}
 */
export function recruitmentParameters(query) {
  const given = new URLSearchParams(query);
  return Object.fromEntries(PARAMETERS.flatMap((name) => (given.get(name) ? [[name, String(given.get(name))]] : [])));
}

/**
 * @param {object} options
 * @param {string} options.title of the study
 * @param {boolean} options.asksCode
 * @param {boolean} options.second the second person at this screen
 * @param {string} options.problem why we are here again
 * @param {Record<string, string>} options.given what the link says already
 * @param {(parameters: Record<string, string>) => Promise<void>} options.arrive
 * @param {(() => void) | null} options.cancel
 * @returns {Screen}
 */
export function arrivalScreen({ title, asksCode, second, problem, given, arrive, cancel }) {
  const box = problemBox();
  showProblem(box, problem);
  const input = el("input", {
    id: "code",
    class: "input code-input",
    autocomplete: "off",
    autocapitalize: "characters",
    spellcheck: "false",
    maxlength: 64,
    value: given.code,
    "aria-describedby": "code-help",
  });
  const field = el(
    "div",
    { class: "field" },
    el("label", { for: "code" }, say("study.arrival.code")),
    input,
    el("p", { id: "code-help", class: "field-help" }, say("study.arrival.codeHelp")),
  );
  const begin = el("button", { type: "submit", class: "button button-primary" }, say("study.arrival.begin"));
  const back = cancel && el("button", { type: "button", class: "button", onclick: cancel }, say("study.page.cancel"));
  const form = el(
    "form",
    { class: "stack", novalidate: true },
    box,
    asksCode ? field : null,
    el("div", { class: "row" }, begin, back),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const code = input.value.trim();
    if (!asksCode) return void runAction(begin, box, () => arrive(given));
    if (code) return void runAction(begin, box, () => arrive({ ...given, code }));
    showProblem(box, say("study.arrival.codeMissing"));
    input.focus();
  });
  const lead = el("p", { class: "lead" }, say(second ? "study.arrival.secondLead" : "study.arrival.lead"));
  const head = heading(
    second ? say("study.arrival.secondTitle") : title || say("study.arrival.title"),
    second ? title : say("study.arrival.title"),
  );
  return { root: card(head, lead, form) };
}
