// @ts-check
/*
 * The metrics over an episode: a small curve each, beside it the values at the shown tick and at the end; a click goes
 * to a tick. Scales and paths are pure functions; MetricCharts puts them on the page.
 */

import { el } from "../core/dom.js";
import { measures, valueText } from "../play/result/result_words.js";

/** @typedef {import("../messages.js").Metric} Metric */
/** @typedef {{low: number, high: number}} Scale */

const NAMESPACE = "http://www.w3.org/2000/svg";
export const WIDTH = 200;
export const HEIGHT = 32;
const MARGIN = 2; // half the stroke width and a little space

/**
 * The range of the vertical axis: the metric's bounds; where it has none, 0 and 1 or as far as the values reach.
 * @param {Metric} metric
 * @param {(number | null)[]} values
 * @returns {Scale}
 */
export function scaleOf({ low, high }, values) {
  const known = values.filter((value) => value !== null);
  return { low: low ?? Math.min(0, ...known), high: high ?? Math.max(1, ...known) };
}

/** The horizontal position of a tick. @param {number} tick @param {number} ticks */
export function placeOf(tick, ticks) {
  return (WIDTH * tick) / Math.max(ticks, 1);
}

/**
 * The SVG path of a curve, with a gap where there is no value.
 * @param {(number | null)[]} values
 * @param {Scale} scale
 */
export function pathOf(values, { low, high }) {
  const y = (/** @type {number} */ value) => HEIGHT - MARGIN - ((value - low) / (high - low)) * (HEIGHT - 2 * MARGIN);
  let path = "";
  for (const [index, value] of values.entries()) {
    if (value === null) continue;
    const drawn = index > 0 && values[index - 1] !== null;
    path += `${drawn ? "L" : "M"}${placeOf(index + 1, values.length).toFixed(1)} ${y(value).toFixed(1)}`;
  }
  return path;
}

/** The tick at a share of the width. @param {number} part 0 to 1 @param {number} ticks */
export function tickAtPart(part, ticks) {
  return Math.round(Math.min(Math.max(part, 0), 1) * ticks);
}

export class MetricCharts {
  /** @type {{metric: Metric, value: HTMLElement, cursor: SVGElement}[]} */
  #rows = [];

  /**
   * @param {HTMLElement} box
   * @param {Pick<import("./data.js").Summary, "curves" | "metrics" | "ticks">} summary
   * @param {(tick: number) => void} onSeek
   */
  constructor(box, { curves, metrics, ticks }, onSeek) {
    this.curves = curves;
    this.ticks = ticks;
    this.onSeek = onSeek;
    box.replaceChildren(...measures(metrics).map((measure) => this.#row(measure)));
  }

  /** The values after `tick` and the place of the cursor. @param {number} tick */
  show(tick) {
    for (const { metric, value, cursor } of this.#rows) {
      value.textContent = valueText(metric, this.#curve(metric)[tick - 1] ?? null);
      const x = placeOf(tick, this.ticks).toFixed(1);
      cursor.setAttribute("d", `M${x} 0V${HEIGHT}`);
    }
  }

  /** @param {Metric} metric */
  #curve({ key }) {
    return this.curves[key] ?? [];
  }

  /** @param {import("../play/result/result_words.js").Measure} measure */
  #row({ metric, name, value: end }) {
    const values = this.#curve(metric);
    const cursor = shape("path", { class: "replay-curve-cursor" });
    const chart = shape("svg", {
      class: "replay-curve",
      viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
      preserveAspectRatio: "none",
      "aria-hidden": "true",
    });
    chart.append(shape("path", { class: "replay-curve-line", d: pathOf(values, scaleOf(metric, values)) }), cursor);
    chart.addEventListener("pointerdown", (event) => this.#seek(chart, event));
    chart.addEventListener("pointermove", (event) => event.buttons === 1 && this.#seek(chart, event));
    const value = el("span", { class: "replay-curve-value" });
    this.#rows.push({ metric, value, cursor });
    return el(
      "div",
      { class: "replay-curve-row" },
      el("span", {}, name, " ", el("span", { class: "small muted" }, metric.symbol)),
      el("span", {}, value, el("span", { class: "muted" }, ` · ${end}`)),
      chart,
    );
  }

  /** @param {SVGElement} chart @param {PointerEvent} event */
  #seek(chart, event) {
    chart.setPointerCapture(event.pointerId);
    const { left, width } = chart.getBoundingClientRect();
    this.onSeek(tickAtPart((event.clientX - left) / width, this.ticks));
  }
}

/**
 * @template {"svg" | "path"} K
 * @param {K} tag
 * @param {Record<string, string>} attributes
 * @returns {SVGElementTagNameMap[K]}
 */
function shape(tag, attributes) {
  const node = document.createElementNS(NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return /** @type {SVGElementTagNameMap[K]} */ (node);
}
