// @ts-check
/*
 * The consent screen: its text, the boxes to tick, a copy to keep, agree and decline.
 */

import { actionButton, heading, problemBox, showProblem } from "../components/action.js";
import { byId, el } from "../core/dom.js";
import { currentLanguage, say } from "../text/catalogue.js";
import { card, prose } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {{id: string, text: string, required: boolean}} Box */

/** @param {Context} context @returns {Screen} */
export function consentScreen({ step, kept, next, decline, addPerson }) {
  const text = prose(step.html ?? "");
  const problem = problemBox();
  const ticked = (kept.ticked ??= new Set());
  const boxes = (step.boxes ?? []).map((box) => ({ box, ...checkBox(box, ticked.has(box.id)) }));
  for (const { box, input } of boxes) {
    input.addEventListener("change", () => {
      ticked[input.checked ? "add" : "delete"](box.id);
      if (input.checked) input.removeAttribute("aria-invalid");
      if (!boxes.some((one) => one.box.required && !one.input.checked)) showProblem(problem, "");
    });
  }
  const agree = actionButton(say("study.consent.agree"), problem, async () => {
    const missing = markMissing(boxes);
    if (!missing) return next({ boxes: boxes.filter(({ input }) => input.checked).map(({ box }) => box.id) });
    showProblem(problem, say("study.consent.missing"));
    missing.focus();
  });
  const no = actionButton(say("study.consent.decline"), problem, decline, "");
  const save = () => saveCopy(copyOf(title, text, boxes, step.version ?? ""));
  const copy = el("button", { type: "button", class: "button-link small", onclick: save }, say("study.consent.copy"));
  const ticks = boxes.length > 0 ? el("div", { class: "consent-boxes" }, ...boxes.map(({ row }) => row)) : null;
  const title = text.querySelector("h1") ? null : heading(step.title ?? say("study.page.title"));
  return {
    root: card(
      title,
      text,
      ticks,
      problem,
      el("div", { class: "row" }, agree, no),
      el("div", { class: "row row-apart" }, copy, addPerson && secondPerson(addPerson)),
    ),
  };
}

/**
 * Marks the required boxes that are not ticked.
 * @param {{box: Box, input: HTMLInputElement}[]} boxes
 * @returns {HTMLInputElement | undefined} the first of them
 */
function markMissing(boxes) {
  const missing = boxes.filter(({ box, input }) => box.required && !input.checked).map(({ input }) => input);
  for (const { input } of boxes) input.removeAttribute("aria-invalid");
  for (const input of missing) input.setAttribute("aria-invalid", "true");
  return missing[0];
}

/** Offers a second person to join at this screen. @param {() => void} addPerson */
function secondPerson(addPerson) {
  const button = el(
    "button",
    { type: "button", class: "button-link", onclick: addPerson },
    say("study.consent.secondButton"),
  );
  return el("p", { class: "muted small" }, `${say("study.consent.second")} `, button);
}

/** @param {Box} box @param {boolean} checked */
function checkBox(box, checked) {
  const input = el("input", { type: "checkbox", value: box.id, checked });
  const needed = box.required ? el("span", { class: "muted small" }, ` (${say("study.consent.required")})`) : null;
  return { input, row: el("label", { class: "check" }, input, el("span", {}, box.text, needed)) };
}

/**
 * The whole page, for the participant to keep: the study, its text, the boxes as they are now, version and date.
 * @param {HTMLElement | null} title null: the text has its own
 * @param {HTMLElement} text
 * @param {{row: HTMLElement, input: HTMLInputElement}[]} boxes
 * @param {string} version
 * @returns {string} HTML
 */
function copyOf(title, text, boxes, version) {
  const study = byId("study-title", HTMLElement).textContent ?? "";
  const date = new Date().toLocaleDateString(currentLanguage(), { dateStyle: "long" });
  const body = el(
    "body",
    {},
    el("p", {}, study),
    title && el("h1", {}, title.textContent ?? ""),
    text.cloneNode(true),
    ...boxes.map(({ row, input }) => el("p", {}, `${input.checked ? "☑" : "☐"} ${row.textContent}`)),
    el("p", {}, say("study.consent.copyMade", { version, date })),
  );
  const names = [(title ?? text.querySelector("h1"))?.textContent, study].filter(Boolean).join(" · ");
  const head = `<meta charset="utf-8">${el("title", {}, names).outerHTML}`;
  return `<!doctype html><html lang="${currentLanguage()}"><head>${head}</head>${body.outerHTML}</html>`;
}

/** Saves it as a file. @param {string} page HTML */
function saveCopy(page) {
  const address = URL.createObjectURL(new Blob([page], { type: "text/html" }));
  el("a", { href: address, download: `${say("study.consent.copyName")}.html` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}
