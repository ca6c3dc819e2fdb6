// @ts-check
/*
 * The consent: its text, the boxes to tick, a copy to keep, yes and no.
 */

import { el } from "../core/dom.js";
import { actionButton, card, complain, heading, problemBox, prose } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {{id: string, text: string, required: boolean}} Box */

/** @param {Context} context @returns {Screen} */
export function consentScreen({ words, step, next, decline, addPerson }) {
  const text = prose(step.html ?? "");
  const problem = problemBox();
  const boxes = (step.boxes ?? []).map((box) => ({ box, ...checkBox(box, words) }));
  const agree = actionButton(words, words.say("consent.agree"), problem, async () => {
    const open = boxes.filter(({ box, input }) => box.required && !input.checked);
    for (const { input } of boxes) input.removeAttribute("aria-invalid");
    for (const { input } of open) input.setAttribute("aria-invalid", "true");
    if (open.length > 0) {
      complain(problem, words.say("consent.missing"));
      return open[0].input.focus();
    }
    await next({ boxes: boxes.filter(({ input }) => input.checked).map(({ box }) => box.id) });
  });
  const no = actionButton(words, words.say("consent.decline"), problem, decline, "");
  const copy = el(
    "button",
    { type: "button", class: "button-link small", onclick: () => saveCopy(words, text) },
    words.say("consent.copy"),
  );
  const second =
    addPerson &&
    el(
      "p",
      { class: "muted small" },
      `${words.say("consent.second")} `,
      el("button", { type: "button", class: "button-link", onclick: addPerson }, words.say("consent.secondButton")),
    );
  const ticks = boxes.length > 0 ? el("div", { class: "consent-boxes" }, ...boxes.map(({ row }) => row)) : null;
  const title = text.querySelector("h1") ? null : heading(step.title ?? words.say("page.title"));
  return {
    root: card(
      title,
      text,
      ticks,
      problem,
      el("div", { class: "row" }, agree, no),
      el("div", { class: "row row-apart" }, copy, second),
    ),
  };
}

/** @param {Box} box @param {import("./words.js").Words} words */
function checkBox(box, words) {
  const input = el("input", { type: "checkbox", value: box.id });
  const needed = box.required ? el("span", { class: "muted small" }, ` (${words.say("consent.required")})`) : null;
  return { input, row: el("label", { class: "check" }, input, el("span", {}, box.text, needed)) };
}

/** Puts what was read into a file of its own. @param {import("./words.js").Words} words @param {HTMLElement} text */
function saveCopy(words, text) {
  const head = `<meta charset="utf-8"><title>${words.say("page.title")}</title>`;
  const page = `<!doctype html><html lang="${words.language}">${head}${text.innerHTML}</html>`;
  const address = URL.createObjectURL(new Blob([page], { type: "text/html" }));
  el("a", { href: address, download: `${words.say("consent.copyName")}.html` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}
