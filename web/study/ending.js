// @ts-check
/*
 * The last screens: the debriefing, which may ask whether to keep the data, and the completion code.
 */

import { actionButton, heading, problemBox, showProblem } from "../components/action.js";
import { el } from "../core/dom.js";
import { currentLanguage, has, say } from "../text/catalogue.js";
import { card, prose } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {import("./service.js").Step} Step */

/** @param {Context} context @returns {Screen} */
export function debriefScreen({ step, next, pay }) {
  const text = prose(step.html ?? "");
  const problem = problemBox();
  const keep = keepOption("keep", pay);
  const remove = keepOption("delete", pay);
  const asks = step.ask_to_keep === true;
  for (const { input } of [keep, remove]) input.addEventListener("change", () => showProblem(problem, ""));
  const on = actionButton(say("study.page.goOn"), problem, async () => {
    if (!asks) return next();
    if (keep.input.checked || remove.input.checked) return next({ keep: keep.input.checked });
    showProblem(problem, say("study.debrief.missing"));
    keep.input.focus();
  });
  const question = asks
    ? el(
        "fieldset",
        { class: "question" },
        el("legend", {}, say("study.debrief.question")),
        el("div", { class: "choice choice-wide" }, keep.row, remove.row),
      )
    : null;
  const title = text.querySelector("h1") ? null : heading(say("study.code.done"));
  return { root: card(title, text, question, problem, el("div", { class: "row" }, on)) };
}

/** @param {"keep" | "delete"} choice @param {"paid" | "unpaid"} pay */
function keepOption(choice, pay) {
  const input = el("input", { type: "radio", name: "keep", value: choice });
  const help = el(
    "span",
    { class: "muted small option-help" },
    say(choice === "keep" ? "study.debrief.keepHelp" : `study.debrief.deleteHelp.${pay}`),
  );
  return {
    input,
    row: el("label", { class: "choice-option" }, input, el("span", {}, say(`study.debrief.${choice}`), help)),
  };
}

/** @param {Context} context @returns {Screen} */
export function codeScreen({ step, several, people, pay, leaveScreen, nextCode }) {
  const outcome = has(`study.code.${step.outcome}`) ? String(step.outcome) : "done";
  const who = several ? say("study.page.person", { number: people[0] + 1 }) : "";
  const lead = `study.code.${outcome}Lead`;
  const after = nextCode
    ? el("button", { type: "button", class: "button", onclick: nextCode }, say("study.code.nextPerson"))
    : step.from_platform || leaveScreen === null
      ? null // they take part alone, at home
      : el("button", { type: "button", class: "button-link small", onclick: leaveScreen }, say("study.code.newPerson"));
  const root = card(
    heading(say(`study.code.${outcome}`), who),
    el("p", { class: "lead" }, say(has(`${lead}.${pay}`) ? `${lead}.${pay}` : lead)),
    step.code ? codeBlock(step, step.code) : null,
    ...(step.html ? debriefing(step.html, step.ask_to_keep === true) : []),
    step.code ? dataSentence(step) : null,
    el(
      "div",
      { class: "row row-apart" },
      step.code ? el("p", { class: "muted small" }, say("study.code.close")) : null,
      after,
    ),
  );
  return { root };
}

/**
 * What who was ended early would have read before the code. Its text may speak of a choice, which they do not have.
 * @param {string} html @param {boolean} asks
 */
function debriefing(html, asks) {
  const text = prose(html);
  const title = text.querySelector("h1");
  title?.replaceWith(el("h2", {}, title.textContent ?? "")); // the page has its own
  return [asks ? el("p", { class: "muted small" }, say("study.code.debriefing")) : null, text];
}

/** @param {Step} step @param {string} code */
function codeBlock(step, code) {
  const said = el("span", { class: "muted small", role: "status" });
  const copy = el(
    "button",
    { type: "button", class: step.completion_url ? "button" : "button button-primary" },
    say("study.code.copy"),
  );
  copy.addEventListener("click", async () => {
    const done = await navigator.clipboard?.writeText(code).then(
      () => true,
      () => false,
    );
    said.textContent = say(done ? "study.code.copied" : "study.code.copyNot");
  });
  const link =
    step.completion_url &&
    el("a", { class: "button button-primary", href: step.completion_url, rel: "noreferrer" }, say("study.code.link"));
  return el(
    "div",
    { class: "stack" },
    el(
      "div",
      { class: "code-box" },
      el("p", { class: "muted small" }, say("study.code.yours")),
      el("p", { class: "code", id: "completion-code", translate: "no" }, code),
      earnedLine(step),
    ),
    codeHelp(step),
    el("div", { class: "row" }, link, copy, said),
  );
}

/** Where the code is needed; nowhere in a study in a laboratory that does not pay. @param {Step} step */
function codeHelp({ from_platform: fromPlatform, earned }) {
  if (fromPlatform) return el("p", {}, say("study.code.help"));
  return earned ? el("p", {}, say("study.code.helpHere")) : null;
}

/** @param {Step} step */
function earnedLine({ earned }) {
  if (!earned) return null;
  const amount = new Intl.NumberFormat(currentLanguage(), { style: "currency", currency: earned.currency }).format(
    earned.amount,
  );
  const minutes = earned.minutes.toLocaleString(currentLanguage(), { maximumFractionDigits: 1 }); // as the pay has it
  return el("p", {}, earned.minutes > 0 ? say("study.code.earned", { amount, minutes }) : amount);
}

/** @param {Step} step */
function dataSentence({ kept, shared_code: shared, from_platform: fromPlatform }) {
  if (kept === false) return el("p", { class: "muted small" }, say("study.code.deleted"));
  const later = shared ? (fromPlatform ? "laterById" : "laterByTime") : "later";
  return el("p", { class: "muted small" }, `${say("study.code.kept")} ${say(`study.code.${later}`)}`);
}
