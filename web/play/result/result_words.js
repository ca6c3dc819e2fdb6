// @ts-check
/*
 * How a round ended, in words for people. A metric is shown by its row in METRICS and its texts play.measure.<key>:
 * its name, what it means (.help), and for some what it means below zero (.negative) or without a value (.none).
 */

import { METRICS } from "../../messages.js";
import { secondsOf } from "../../core/ticks.js";
import { has, say, sayNumber } from "../../text/catalogue.js";
import { isBetter } from "./best_rounds.js";

const OUTCOMES = ["delivered", "time", "left", "stopped"];

/** @typedef {import("../../messages.js").Metric} Metric */
/** @typedef {import("../../core/metric_values.js").MetricValues} MetricValues */
/** @typedef {{metric: Metric, name: string, value: string, help: string}} Measure a metric in words */

/**
 * "You delivered 4 of 6".
 * @param {{delivered: number, items: number}} result @param {boolean} [plays] the reader played
 */
export function headline({ delivered, items }, plays = false) {
  const key = `play.result.${plays ? "own" : "any"}.${delivered === items ? "all" : "some"}`;
  return say(key, { delivered, items });
}

/**
 * Why a round ended, as a headline.
 * @param {{outcome: string}} result
 * @param {boolean} [byYou] the reader stopped the round
 */
export function outcomeText({ outcome }, byYou = false) {
  if (byYou && outcome !== "delivered") return say("play.result.headline.byYou");
  return say(`play.result.headline.${OUTCOMES.includes(outcome) ? outcome : "error"}`);
}

/**
 * Why a round ended, and how long it took where everything was delivered, as a sentence.
 * @param {{outcome: string, ticks: number}} result
 * @param {boolean} [byYou] the reader stopped the round
 * @param {string} [reason] what the room says about it: who left, or did not come back
 */
export function howItEnded(result, byYou = false, reason = "") {
  if (result.outcome === "delivered") return say("play.result.took", { time: duration(result.ticks) });
  if (reason && !byYou && result.outcome !== "time") return reason;
  return `${outcomeText(result, byYou)}.`;
}

/**
 * How it compares with the best round before; empty after a first round and after one that did not run to its end.
 * @param {import("./best_rounds.js").Score & {outcome: string, items: number}} result
 * @param {import("./best_rounds.js").Score | null} best
 */
export function bestText(result, best) {
  if (best === null) return "";
  if (isBetter(result, best)) return say("play.result.best.new");
  const { delivered, ticks } = best;
  if (delivered === result.items) return say("play.result.best.all", { time: duration(ticks) });
  return say("play.result.best.some", { delivered, items: result.items });
}

/** @param {number} ticks */
export function duration(ticks) {
  const seconds = secondsOf(ticks);
  if (seconds < 60) return say("play.result.seconds", { seconds: sayNumber(seconds, 1) });
  const whole = Math.round(seconds);
  return say("play.result.minutes", { minutes: Math.floor(whole / 60), seconds: whole % 60 });
}

/** The metrics that have been sent. @param {MetricValues} values @returns {Measure[]} */
export function measures(values) {
  return METRICS.flatMap((metric) => {
    const value = values[metric.key];
    return value === undefined ? [] : [measure(metric, value)];
  });
}

/** @param {Metric} metric @param {number | null} value @returns {Measure} */
function measure(metric, value) {
  const name = `play.measure.${metric.key}`;
  const negative = value !== null && value < 0 && has(`${name}.negative`);
  const variant = value === null ? "none" : negative ? "negative" : "help";
  return { metric, name: say(name), value: valueText(metric, value), help: say(`${name}.${variant}`) };
}

/** A share as a percentage, anything else with its unit. @param {Metric} metric @param {number | null} value */
export function valueText({ unit, high, digits }, value) {
  if (value === null) return "–";
  if (unit === "" && high === 1) return percent(value);
  return `${sayNumber(value, digits)} ${unit}`.trimEnd();
}

/** @param {number} share usually 0 to 1 */
export function percent(share) {
  const whole = Math.round(100 * share);
  return `${whole < 0 ? "\u2212" : ""}${Math.abs(whole)} %`;
}
