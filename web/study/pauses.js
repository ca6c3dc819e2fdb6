// @ts-check
/*
 * Screens that ask nothing: the waiting room, a break, a pause by the experimenter, the study open in another tab.
 * Times count on between updates from the server.
 */

import { actionButton, heading, problemBox } from "../components/action.js";
import { el } from "../core/dom.js";
import { Elapsed } from "../core/elapsed.js";
import { say } from "../text/catalogue.js";
import { card } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {import("./screen.js").Step} Step */

const SECOND_MS = 1000;

/**
 * Calls `show` with the seconds since this call, or since the time given, now and every second.
 * @param {(seconds: number) => void} show
 */
function everySecond(show, since = new Elapsed()) {
  const tick = () => show(since.ms / SECOND_MS);
  tick();
  const timer = setInterval(tick, SECOND_MS);
  return () => clearInterval(timer);
}

/** 65 seconds -> "1:05". @param {number} seconds */
export function clock(seconds) {
  const whole = Math.max(0, Math.round(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/** @param {Context} context @returns {Screen} */
export function waitingScreen({ step, addPerson, refresh, pay }) {
  const most = step.wait_s ?? 0;
  const bar = el("progress", { class: "bar", max: Math.max(1, most), "aria-label": say("study.waiting.title") });
  const since = el("p", { class: "label" });
  const others = el("p", { class: "muted small", role: "status" });
  const then = step.otherwise === "agent" ? say("study.waiting.thenAgent") : say(`study.waiting.thenCode.${pay}`);
  let base = step.since_s ?? 0;
  const show = (/** @type {number} */ seconds) => {
    const waited = base + seconds;
    bar.value = Math.min(waited, most);
    const over = most > 0 && waited > most;
    since.textContent = over ? say("study.waiting.soon") : say("study.waiting.since", { time: clock(waited) });
    if (over) refresh(); // the server knows by now what follows
  };
  const tell = (/** @type {Step} */ news) => {
    const text = othersText(news.people ?? 1);
    if (others.textContent !== text) others.textContent = text; // a status is read out when it is set
  };
  let stop = everySecond(show);
  tell(step);
  const limit = el("span", { class: "muted" }, say("study.waiting.most", { time: clock(most) }));
  const root = card(
    heading(say("study.waiting.title")),
    el("p", { class: "lead" }, say("study.waiting.lead")),
    el("div", { class: "stack stack-tight" }, el("div", { class: "row row-apart" }, since, limit), bar),
    el("p", {}, then),
    others,
    el("p", { class: "muted small" }, say("study.waiting.keepOpen")),
    addPerson && secondPerson(addPerson),
  );
  const update = (/** @type {Step} */ news) => {
    base = news.since_s ?? base;
    tell(news);
    stop();
    stop = everySecond(show);
  };
  return { root, update, close: () => stop() };
}

/** @param {number} people who wait, with the reader */
function othersText(people) {
  return people <= 1 ? say("study.waiting.alone") : say("study.waiting.others", { people });
}

/** Offers a second person to join at this screen. @param {() => void} addPerson */
function secondPerson(addPerson) {
  const button = el(
    "button",
    { type: "button", class: "button button-small", onclick: addPerson },
    say("study.consent.secondButton"),
  );
  return el("p", {}, `${say("study.consent.second")} `, button);
}

/** @param {Context} context @returns {Screen} */
export function breakScreen({ step, kept, next }) {
  const all = step.seconds ?? 0;
  const problem = problemBox();
  const left = el("p", { class: "label" });
  const bar = el("progress", { class: "bar", max: Math.max(1, all), "aria-label": say("study.break.title") });
  const stop = everySecond(
    (seconds) => {
      bar.value = Math.max(0, all - seconds);
      left.textContent =
        seconds < all ? say("study.break.left", { time: clock(all - seconds) }) : say("study.break.over");
    },
    (kept.since ??= new Elapsed()),
  );
  const on = actionButton(say("study.page.goOn"), problem, () => next());
  const root = card(
    heading(say("study.break.title")),
    el("p", { class: "lead" }, say("study.break.lead")),
    all > 0 ? el("div", { class: "stack stack-tight" }, left, bar) : null,
    problem,
    el("div", { class: "row" }, on),
  );
  return { root, close: stop };
}

/** @returns {Screen} */
export function pausedScreen() {
  return { root: card(heading(say("study.paused.title")), el("p", { class: "lead" }, say("study.paused.lead"))) };
}

/** @returns {Screen} */
export function elsewhereScreen() {
  const here = el(
    "button",
    { type: "button", class: "button", onclick: () => location.reload() },
    say("study.elsewhere.here"),
  );
  return {
    root: card(
      heading(say("study.elsewhere.title")),
      el("p", { class: "lead" }, say("study.elsewhere.lead")),
      el("div", { class: "row" }, here),
    ),
  };
}
