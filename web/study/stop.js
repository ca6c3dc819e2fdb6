// @ts-check
/*
 * The Stop dialog, on every screen and in the game: asks whether to keep or delete the data so far and, where two
 * people share the screen, who stops.
 */

import { problemBox, runAction } from "../components/action.js";
import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";

/** @typedef {import("./service.js").Place} Place */
/** @typedef {(person: number, keep: boolean) => Promise<void>} Stop */

/**
 * @param {readonly number[]} people numbers of the one or two who can stop here
 * @param {"paid" | "unpaid"} pay whether the study pays
 * @param {Stop} stop rejects with an ApiError
 * @returns {Promise<boolean>} whether somebody has stopped
 */
export function askToStop(people, pay, stop) {
  const dialog = el("dialog", { class: "card card-roomy dialog", "aria-labelledby": "stop-title" });
  const problem = problemBox();
  const who = whoField(people);
  let stopped = false;
  const stopThem = async (/** @type {boolean} */ keep) => {
    for (const person of who.chosen()) await stop(person, keep);
    stopped = true;
    dialog.close();
  };
  const no = el(
    "button",
    { type: "button", class: "button button-primary button-wide", autofocus: true, onclick: () => dialog.close() },
    say("study.stop.no"),
  );
  dialog.append(
    el(
      "div",
      { class: "stack" },
      el("h2", { id: "stop-title" }, say("study.stop.title")),
      el("p", {}, say(`study.stop.lead.${pay}`)),
      who.field,
      problem,
      choice(true, problem, stopThem),
      choice(false, problem, stopThem),
      no,
    ),
  );
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      done(stopped);
    });
  });
}

/**
 * A way to stop, with what it does to the data.
 * @param {boolean} keep
 * @param {HTMLElement} problem
 * @param {(keep: boolean) => Promise<void>} stop
 */
function choice(keep, problem, stop) {
  const name = keep ? "keep" : "delete";
  const button = el(
    "button",
    { type: "button", class: keep ? "button button-wide" : "button button-wide button-danger" },
    say(`study.stop.${name}`),
  );
  button.addEventListener("click", () => runAction(button, problem, () => stop(keep)));
  return el("div", {}, button, el("p", { class: "muted small dialog-help" }, say(`study.stop.${name}Help`)));
}

/** @param {readonly number[]} people */
function whoField(people) {
  if (people.length < 2) return { field: null, chosen: () => people };
  const groups = [...people.map((person) => [person]), [...people]];
  const rows = groups.map((group, index) => {
    const input = el("input", { type: "radio", name: "who", value: index, checked: index === groups.length - 1 });
    const name = group.length > 1 ? say("study.stop.both") : say("study.page.person", { number: group[0] + 1 });
    return { input, group, row: el("label", { class: "choice-option" }, input, el("span", {}, name)) };
  });
  const field = el(
    "fieldset",
    { class: "question" },
    el("legend", {}, say("study.stop.who")),
    el("div", { class: "choice" }, ...rows.map(({ row }) => row)),
  );
  return { field, chosen: () => rows.find(({ input }) => input.checked)?.group ?? people };
}
