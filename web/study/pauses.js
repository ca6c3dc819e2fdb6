// @ts-check
/*
 * Screens on which nothing is asked: the waiting room, a break, a pause by the experimenter, the study open elsewhere.
 * Times run on by themselves between news from the server.
 */

import { el } from "../core/dom.js";
import { actionButton, card, heading, problemBox } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */

const SECOND_MS = 1000;

/**
 * Calls `show` with the seconds since `since_s` was true, now and each second.
 * @param {(seconds: number) => void} show
 */
function everySecond(show) {
  const start = performance.now();
  const tick = () => show((performance.now() - start) / 1000);
  tick();
  const timer = setInterval(tick, SECOND_MS);
  return () => clearInterval(timer);
}

/** @param {Context} context @returns {Screen} */
export function waitingScreen({ words, step, addPerson, refresh }) {
  const most = step.wait_s ?? 0;
  const bar = el("progress", { class: "bar", max: Math.max(1, most), "aria-label": words.say("waiting.title") });
  const since = el("p", { class: "label" });
  const others = el("p", { class: "muted small", role: "status" });
  const then = words.say(step.otherwise === "agent" ? "waiting.thenAgent" : "waiting.thenCode");
  let base = step.since_s ?? 0;
  const show = (/** @type {number} */ seconds) => {
    const waited = base + seconds;
    bar.value = Math.min(waited, most);
    const over = most > 0 && waited > most;
    since.textContent = over ? words.say("waiting.soon") : words.say("waiting.since", { time: words.clock(waited) });
    if (over) refresh(); // what follows is known by now
  };
  const tell = (/** @type {import("./screen.js").Step} */ news) => {
    const alone = (news.people ?? 1) <= 1;
    const text = alone ? words.say("waiting.alone") : words.say("waiting.others", { people: news.people ?? 1 });
    if (others.textContent !== text) others.textContent = text;
  };
  let stop = everySecond(show);
  tell(step);
  const second =
    addPerson &&
    el(
      "p",
      {},
      `${words.say("consent.second")} `,
      el(
        "button",
        { type: "button", class: "button button-small", onclick: addPerson },
        words.say("consent.secondButton"),
      ),
    );
  const root = card(
    heading(words.say("waiting.title")),
    el("p", { class: "lead" }, words.say("waiting.lead")),
    el(
      "div",
      { class: "stack stack-tight" },
      el(
        "div",
        { class: "row row-apart" },
        since,
        el("span", { class: "muted" }, words.say("waiting.most", { time: words.clock(most) })),
      ),
      bar,
    ),
    el("p", {}, then),
    others,
    el("p", { class: "muted small" }, words.say("waiting.keepOpen")),
    second,
  );
  const update = (/** @type {import("./screen.js").Step} */ news) => {
    base = news.since_s ?? base;
    tell(news);
    stop();
    stop = everySecond(show);
  };
  return { root, update, close: () => stop() };
}

/** @param {Context} context @returns {Screen} */
export function breakScreen({ words, step, next }) {
  const all = step.seconds ?? 0;
  const problem = problemBox();
  const left = el("p", { class: "label" });
  const bar = el("progress", { class: "bar", max: Math.max(1, all), "aria-label": words.say("break.title") });
  const stop = everySecond((seconds) => {
    bar.value = Math.max(0, all - seconds);
    left.textContent =
      seconds < all ? words.say("break.left", { time: words.clock(all - seconds) }) : words.say("break.over");
  });
  const on = actionButton(words, words.say("page.goOn"), problem, () => next());
  const root = card(
    heading(words.say("break.title")),
    el("p", { class: "lead" }, words.say("break.lead")),
    all > 0 ? el("div", { class: "stack stack-tight" }, left, bar) : null,
    problem,
    el("div", { class: "row" }, on),
  );
  return { root, close: stop };
}

/** @param {Context} context @returns {Screen} */
export function pausedScreen({ words }) {
  return { root: card(heading(words.say("paused.title")), el("p", { class: "lead" }, words.say("paused.lead"))) };
}

/** @param {Context} context @returns {Screen} */
export function elsewhereScreen({ words }) {
  const here = el(
    "button",
    { type: "button", class: "button", onclick: () => location.reload() },
    words.say("elsewhere.here"),
  );
  return {
    root: card(
      heading(words.say("elsewhere.title")),
      el("p", { class: "lead" }, words.say("elsewhere.lead")),
      el("div", { class: "row" }, here),
    ),
  };
}
