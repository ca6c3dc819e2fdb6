// @ts-check
/*
 * The four metrics over an episode: a small curve each, beside it the values at the shown tick and at the end; a click
 * goes to a tick. Scales and paths are pure functions; MetricCurves puts them on the page.
 */

import { el } from "../core/dom.js";
import { measures } from "../play/result_words.js";

/**
 * The metrics after each tick, from tick 1 on; `ac` is -1 until something is carried together.
 * @typedef {{tcr: number[], nfd: number[], wt_s: number[], ac: number[]}} Curves
 */
/** @typedef {{low: number, high: number}} Scale */

const NAMESPACE = "http://www.w3.org/2000/svg";
export const WIDTH = 200;
export const HEIGHT = 32;
const MARGIN = 2; // half the stroke width and a little space
const FIELDS = /** @type {const} */ ({ tcr: "tcr", nfd: "nfd", wt: "wt_s", ac: "ac" });

/**
 * The range of the vertical axis: 0 to 1 for shares, lower for a negative NFD, up to the maximum for waiting time.
 * @param {keyof Curves} field
 * @param {number[]} values
 * @returns {Scale}
 */
export function scaleOf(field, values) {
  if (field === "wt_s") return { low: 0, high: Math.max(1, ...values) };
  return { low: field === "nfd" ? Math.min(0, ...values) : 0, high: 1 };
}

/** The horizontal position of a tick. @param {number} tick @param {number} ticks */
export function placeOf(tick, ticks) {
  return (WIDTH * tick) / Math.max(ticks, 1);
}

/**
 * The SVG path of a curve; an AC of -1 leaves a gap.
 * @param {number[]} values
 * @param {Scale} scale
 */
export function pathOf(values, { low, high }) {
  const y = (/** @type {number} */ value) => HEIGHT - MARGIN - ((value - low) / (high - low)) * (HEIGHT - 2 * MARGIN);
  let path = "";
  for (const [index, value] of values.entries()) {
    if (value === -1) continue;
    const drawn = index > 0 && values[index - 1] !== -1;
    path += `${drawn ? "L" : "M"}${placeOf(index + 1, values.length).toFixed(1)} ${y(value).toFixed(1)}`;
  }
  return path;
}

/** The tick at a share of the width. @param {number} part 0 to 1 @param {number} ticks */
export function tickAtPart(part, ticks) {
  return Math.round(Math.min(Math.max(part, 0), 1) * ticks);
}

export class MetricCurves {
  /** @type {{field: keyof Curves, id: string, value: HTMLElement, cursor: SVGElement}[]} */
  #rows = [];

  /**
   * @param {HTMLElement} box
   * @param {Curves} curves
   * @param {import("./data.js").Summary["metrics"]} end how the episode ended
   * @param {(tick: number) => void} onSeek
   */
  constructor(box, curves, end, onSeek) {
    this.curves = curves;
    this.ticks = curves.tcr.length;
    this.onSeek = onSeek;
    box.replaceChildren(...measures(end).map((measure) => this.#row(measure)));
  }

  /** The values after `tick` and the place of the cursor. @param {number} tick */
  show(tick) {
    const at = (/** @type {keyof Curves} */ field) => this.curves[field][tick - 1] ?? (field === "ac" ? -1 : 0);
    const now = measures({ tcr: at("tcr"), nfd: at("nfd"), wt_s: at("wt_s"), ac: at("ac") });
    for (const { id, value, cursor } of this.#rows) {
      value.textContent = tick === 0 ? "–" : (now.find((measure) => measure.id === id)?.value ?? "");
      const x = placeOf(tick, this.ticks).toFixed(1);
      cursor.setAttribute("d", `M${x} 0V${HEIGHT}`);
    }
  }

  /** @param {import("../play/result_words.js").Measure} measure */
  #row({ id, name, short, value: end }) {
    const field = FIELDS[/** @type {keyof typeof FIELDS} */ (id)];
    const values = this.curves[field];
    const cursor = shape("path", { class: "replay-curve-cursor" });
    const chart = shape("svg", {
      class: "replay-curve",
      viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
      preserveAspectRatio: "none",
      "aria-hidden": "true",
    });
    chart.append(shape("path", { class: "replay-curve-line", d: pathOf(values, scaleOf(field, values)) }), cursor);
    chart.addEventListener("pointerdown", (event) => this.#seek(chart, event));
    chart.addEventListener("pointermove", (event) => event.buttons === 1 && this.#seek(chart, event));
    const value = el("span", { class: "replay-curve-value" });
    this.#rows.push({ field, id, value, cursor });
    return el(
      "div",
      { class: "replay-curve-row" },
      el("span", {}, name, " ", el("span", { class: "small muted" }, short)),
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
