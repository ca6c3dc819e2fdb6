// @ts-check
/*
 * The view after a round: what was delivered, the metrics in plain words, and how to go on.
 */

import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { mapTitle } from "../text/names.js";
import { context2d, drawScene, fitCanvas } from "../view/render.js";
import { duration, headline, measures } from "./result_words.js";
import { roundText } from "./seat_phrases.js";

/** @typedef {import("./game.js").RoundResult} Result */
/** @typedef {import("./result_words.js").Measure} Measure */
/**
 * The server's `round` message.
 * @typedef {{index: number, total: number, map: import("../view/render.js").GameMap}} Round
 */
/**
 * @typedef {object} Options
 * @property {Result} result
 * @property {Round} round
 * @property {boolean} isLast no further round follows
 * @property {() => void} [onNext] go on; absent for spectators
 * @property {() => void} [onAgain] play this map once more; absent for spectators
 * @property {boolean} [stoppedHere] somebody on this page stopped the round
 * @property {string} nextLabel what `onNext` leads to
 * @property {string} [replayPath]
 * @property {import("../view/render.js").View} [view] how the arena looked at the end
 */

/**
 * @param {HTMLElement} container
 * @param {Omit<Options, "nextLabel"> & {nextLabel?: string}} options
 */
export function showResult(container, options) {
  const heading = el("h2", { tabindex: "-1" }, headline(options.result, options.stoppedHere));
  const card = el(
    "div",
    { class: "card card-roomy stack result-card" },
    el("dl", { class: "metrics" }, ...measures(options.result.metrics).map(measureEntry)),
  );
  const parts = [
    header(heading, options),
    card,
    actions({ nextLabel: say(options.isLast ? "play.result.finish" : "play.result.next"), ...options }),
  ];
  container.replaceChildren(el("section", { class: "result", "aria-label": say("play.result.title") }, ...parts));
  drawEnd(container, options);
  heading.focus({ preventScroll: true });
}

/** @param {HTMLElement} heading @param {Pick<Options, "result" | "round" | "view">} options */
function header(heading, { result, round, view }) {
  const title = mapTitle(round.map);
  const where = round.total > 1 ? `${roundText(round)} · ${title}` : title;
  const { delivered, items } = result;
  const sentence = say("play.result.delivered", { delivered, items, time: duration(result.ticks) });
  return el(
    "header",
    { class: "result-head" },
    el(
      "div",
      {},
      el("p", { class: "muted" }, where),
      heading,
      el("p", { class: "muted" }, sentence),
      deliveredRow(result),
    ),
    view ? el("canvas", { class: "result-end", role: "img", "aria-label": say("play.result.end") }) : null,
  );
}

/** One mark per item, filled for each that was delivered. @param {Result} result */
function deliveredRow({ delivered, items }) {
  const marks = Array.from({ length: items }, (_, index) =>
    index < delivered
      ? el("span", { class: "result-item result-item-done" }, "✓")
      : el("span", { class: "result-item" }),
  );
  return el("div", { class: "result-delivered", "aria-hidden": "true" }, ...marks);
}

/** @param {Measure} measure */
function measureEntry({ metric, name, value, help }) {
  return el(
    "div",
    { class: "metric", "data-measure": metric.key },
    el("dt", {}, name, " ", el("span", { class: "metric-short" }, metric.symbol)),
    el("dd", { class: "metric-value" }, value),
    el("dd", { class: "metric-help" }, help),
  );
}

/** @param {Options} options */
function actions({ onNext, onAgain, nextLabel, replayPath }) {
  return el(
    "div",
    { class: "row" },
    onNext && el("button", { type: "button", class: "button button-primary", onclick: onNext }, nextLabel),
    onAgain && el("button", { type: "button", class: "button", onclick: onAgain }, say("play.result.again")),
    replayPath
      ? el("a", { class: "button", href: replayPath, target: "_blank", rel: "noopener" }, say("play.result.replay"))
      : null,
  );
}

/** @param {HTMLElement} container @param {Pick<Options, "round" | "view">} options */
function drawEnd(container, { round, view }) {
  const canvas = container.querySelector("canvas");
  if (!canvas || !view) return;
  fitCanvas(canvas);
  drawScene(context2d(canvas), round.map, view, { plain: true });
}
