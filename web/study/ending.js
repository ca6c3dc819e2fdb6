// @ts-check
/*
 * The last screens: what was not said before with the question whether the data may be kept, and the completion code.
 */

import { el } from "../core/dom.js";
import { actionButton, card, complain, heading, problemBox, prose } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {import("./words.js").Words} Words */
/** @typedef {import("./service.js").Step} Step */

/** @param {Context} context @returns {Screen} */
export function debriefScreen({ words, step, next }) {
  const text = prose(step.html ?? "");
  const problem = problemBox();
  const keep = keepOption(words, "keep");
  const remove = keepOption(words, "delete");
  const asks = step.ask_to_keep === true;
  const on = actionButton(words, words.say("page.goOn"), problem, async () => {
    if (!asks) return next();
    if (keep.input.checked || remove.input.checked) return next({ keep: keep.input.checked });
    complain(problem, words.say("debrief.missing"));
    keep.input.focus();
  });
  const question = asks
    ? el(
        "fieldset",
        { class: "question" },
        el("legend", {}, words.say("debrief.question")),
        el("div", { class: "choice choice-wide" }, keep.row, remove.row),
      )
    : null;
  const title = text.querySelector("h1") ? null : heading(words.say("code.done"));
  return { root: card(title, text, question, problem, el("div", { class: "row" }, on)) };
}

/** @param {Words} words @param {"keep" | "delete"} choice */
function keepOption(words, choice) {
  const input = el("input", { type: "radio", name: "keep", value: choice });
  const help = el("span", { class: "muted small option-help" }, words.say(`debrief.${choice}Help`));
  return {
    input,
    row: el("label", { class: "choice-option" }, input, el("span", {}, words.say(`debrief.${choice}`), help)),
  };
}

/** @param {Context} context @returns {Screen} */
export function codeScreen({ words, step, several, people, leaveScreen, nextCode }) {
  const outcome = words.has(`code.${step.outcome}`) ? String(step.outcome) : "done";
  const who = several ? words.say("page.person", { number: people[0] + 1 }) : "";
  const after = nextCode
    ? el("button", { type: "button", class: "button", onclick: nextCode }, words.say("code.nextPerson"))
    : el("button", { type: "button", class: "button-link small", onclick: leaveScreen }, words.say("code.newPerson"));
  const root = card(
    heading(words.say(`code.${outcome}`), who),
    el("p", { class: "lead" }, words.say(`code.${outcome}Lead`)),
    step.code ? codeBlock(words, step, step.code) : null,
    step.code ? dataSentence(words, step) : null,
    el(
      "div",
      { class: "row row-apart" },
      step.code ? el("p", { class: "muted small" }, words.say("code.close")) : null,
      after,
    ),
  );
  return { root };
}

/** @param {Words} words @param {Step} step @param {string} code */
function codeBlock(words, step, code) {
  const said = el("span", { class: "muted small", role: "status" });
  const copy = el(
    "button",
    { type: "button", class: step.completion_url ? "button" : "button button-primary" },
    words.say("code.copy"),
  );
  copy.addEventListener("click", async () => {
    const done = await navigator.clipboard?.writeText(code).then(
      () => true,
      () => false,
    );
    said.textContent = words.say(done ? "code.copied" : "code.copyNot");
  });
  const link =
    step.completion_url &&
    el("a", { class: "button button-primary", href: step.completion_url, rel: "noreferrer" }, words.say("code.link"));
  return el(
    "div",
    { class: "stack" },
    el(
      "div",
      { class: "code-box" },
      el("p", { class: "muted small" }, words.say("code.yours")),
      el("p", { class: "code", id: "completion-code" }, code),
      earnedLine(words, step),
    ),
    el("p", {}, words.say("code.help")),
    el("div", { class: "row" }, link, copy, said),
  );
}

/** @param {Words} words @param {Step} step */
function earnedLine(words, { earned }) {
  if (!earned) return null;
  const amount = new Intl.NumberFormat(words.language, { style: "currency", currency: earned.currency }).format(
    earned.amount,
  );
  return el("p", {}, words.say("code.earned", { amount, minutes: Math.round(earned.minutes) }));
}

/** @param {Words} words @param {Step} step */
function dataSentence(words, { kept }) {
  if (kept === false) return el("p", { class: "muted small" }, words.say("code.deleted"));
  return el("p", { class: "muted small" }, `${words.say("code.kept")} ${words.say("code.later")}`);
}
