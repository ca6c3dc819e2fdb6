// @ts-check
/*
 * The view after a round, for people: what was delivered and by whom, the best so far, how to play on, and a picture to
 * share. The metrics are folded under Details.
 */

import { el } from "../../core/dom.js";
import { say } from "../../text/catalogue.js";
import { mapTitle } from "../../text/names.js";
import { context2d, drawScene, fitCanvas } from "../../view/render.js";
import { deliveryList } from "./deliveries.js";
import { bestText, headline, howItEnded, measures } from "./result_words.js";
import { roundText } from "../seat_phrases.js";

/** @typedef {import("../game.js").RoundResult} Result */
/** @typedef {import("./result_words.js").Measure} Measure */
/**
 * The server's `round` message.
 * @typedef {{index: number, total: number, map: import("../../view/render.js").GameMap}} Round
 */
/**
 * @typedef {{text: string, href?: string, onclick?: () => void}} Way a way on: a link, which may do something first, or
 *   a button
 */
/**
 * @typedef {object} Options
 * @property {Result} result
 * @property {Round} round
 * @property {readonly Way[]} ways how to go on; the first is the main one
 * @property {readonly string[]} names of the seats
 * @property {boolean} [plays] somebody on this page played
 * @property {boolean} [stoppedHere] somebody on this page stopped the round
 * @property {string} [reason] what the room says about the end
 * @property {import("./best_rounds.js").Score | null} [best] so far in this browser; none for a first round
 * @property {readonly HTMLElement[]} [sharing] what shares or shows the round again
 * @property {HTMLElement} [problem] says why a way on is closed
 * @property {HTMLElement} [company] says who has left, or is ready for the next round
 * @property {readonly HTMLElement[]} [asides] small print below
 * @property {import("../../view/render.js").View} [view] how the arena looked at the end
 */

/** @param {HTMLElement} container @param {Options} options */
export function showResult(container, options) {
  const { result, sharing = [], asides = [] } = options;
  const heading = el("h1", { tabindex: "-1" }, headline(result, options.plays));
  const parts = [
    el("header", { class: "result-head" }, ...headWords(heading, options)),
    el("div", { class: "row result-ways" }, ...options.ways.map(wayOn)),
    options.company ?? "",
    options.problem ?? "",
    options.view ? el("canvas", { class: "result-end", role: "img", "aria-label": say("play.result.end") }) : "",
    deliveries(options),
    el("div", { class: "row result-sharing" }, ...sharing),
    details(result),
    el("div", { class: "result-asides small" }, ...asides),
  ];
  container.replaceChildren(el("section", { class: "result", "aria-label": say("play.result.title") }, ...parts));
  keepDrawn(container.querySelector("canvas"), options);
  heading.focus({ preventScroll: true });
  scrollTo(0, 0);
}

/** @param {HTMLElement} heading @param {Options} options */
function headWords(heading, { result, round, stoppedHere = false, reason, best = null, plays = false }) {
  const title = mapTitle(round.map);
  const remembered = plays ? bestText(result, best) : "";
  return [
    el("p", { class: "muted" }, round.total > 1 ? `${roundText(round)} · ${title}` : title),
    heading,
    el("p", {}, howItEnded(result, stoppedHere, reason)),
    remembered ? el("p", { class: "result-best" }, remembered) : "",
  ];
}

/** @param {Way} way @param {number} place */
function wayOn({ text, href, onclick }, place) {
  const look = place === 0 ? "button button-primary" : "button";
  return href
    ? el("a", { class: look, href, onclick }, text)
    : el("button", { type: "button", class: look, onclick }, text);
}

/** @param {Options} options */
function deliveries({ result, round, view, names }) {
  const delivered = view?.delivered ?? (result.delivered_by ?? []).map((seats) => seats.length > 0);
  return el(
    "div",
    { class: "stack result-who" },
    el("h2", {}, say("play.result.who")),
    deliveryList(round.map.items, result.delivered_by ?? [], delivered, names),
  );
}

/** The metrics, for whoever wants to know. @param {Result} result */
function details(result) {
  return el(
    "details",
    { class: "result-details" },
    el("summary", {}, say("play.result.details")),
    el("dl", { class: "metrics" }, ...measures(result.metrics).map(measureEntry)),
  );
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

/**
 * Draws the end of the round whenever the picture has another size or the page another theme.
 * @param {HTMLCanvasElement | null} canvas @param {Pick<Options, "round" | "view">} options
 */
function keepDrawn(canvas, { round, view }) {
  if (!canvas || !view) return;
  const draw = () => {
    fitCanvas(canvas);
    drawScene(context2d(canvas), round.map, view, { plain: canvas.clientWidth < 320 });
  };
  const gone = new AbortController();
  new ResizeObserver((_, observer) => {
    if (canvas.isConnected) return draw();
    observer.disconnect();
    gone.abort();
  }).observe(canvas);
  addEventListener("movingout-theme", draw, { signal: gone.signal });
}
