// @ts-check
/*
 * The first screen, before anyone is known. Asks for a code where the study requires one.
 */

import { heading, problemBox, runAction, showProblem } from "../../components/action.js";
import { el } from "../../core/dom.js";
import { say } from "../../text/catalogue.js";
import { card } from "../screen.js";

/** @typedef {import("../screen.js").Screen} Screen */

/**
 * @typedef {object} ArrivalOptions
 * @property {string} title of the study
 * @property {boolean} asksCode
 * @property {boolean} second the second person at this screen
 * @property {string} problem why the screen is shown again, empty the first time
 * @property {Record<string, string>} given parameters of the link
 * @property {(parameters: Record<string, string>) => Promise<void>} arrive
 * @property {(() => void) | null} cancel
 * @property {() => void} [finished] shows the code of whoever has finished in this browser
 */

/** @param {ArrivalOptions} options @returns {Screen} */
export function arrivalScreen(options) {
  const { title, second } = options;
  const leadKey = options.finished ? "study.arrival.nextLead" : "study.arrival.lead";
  const lead = el("p", { class: "lead" }, say(second ? "study.arrival.secondLead" : leadKey));
  const head = heading(
    second ? say("study.arrival.secondTitle") : title || say("study.arrival.title"),
    second ? title : say("study.arrival.title"),
  );
  return { root: card(head, lead, arrivalForm(options)) };
}

/** @param {ArrivalOptions} options */
function arrivalForm({ problem, given, arrive, cancel, finished, ...options }) {
  const asksCode = options.asksCode || Boolean(given.code); // where the link has a wrong one, it can be set right
  const box = problemBox();
  showProblem(box, problem);
  const { input, field } = codeField(given.code);
  input.addEventListener("input", () => showProblem(box, ""));
  const begin = el("button", { type: "submit", class: "button button-primary" }, say("study.arrival.begin"));
  const back = cancel && el("button", { type: "button", class: "button", onclick: cancel }, say("study.page.cancel"));
  const mine =
    finished && el("button", { type: "button", class: "button", onclick: finished }, say("study.arrival.mine"));
  const row = el("div", { class: "row" }, begin, back, mine ?? null);
  const form = el("form", { class: "stack", novalidate: true }, box, asksCode ? field : null, row);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const code = input.value.trim();
    if (!asksCode) return void runAction(begin, box, () => arrive(given));
    if (code) return void runAction(begin, box, () => arrive({ ...given, code }));
    showProblem(box, say("study.arrival.codeMissing"));
    input.focus();
  });
  return form;
}

/** @param {string | undefined} code from the link */
function codeField(code) {
  const input = el("input", {
    id: "code",
    class: "input code-input",
    autocomplete: "off",
    autocapitalize: "characters",
    spellcheck: "false",
    maxlength: 64,
    value: code,
    "aria-describedby": "code-help",
  });
  const field = el(
    "div",
    { class: "field" },
    el("label", { for: "code" }, say("study.arrival.code")),
    input,
    el("p", { id: "code-help", class: "field-help" }, say("study.arrival.codeHelp")),
  );
  return { input, field };
}
