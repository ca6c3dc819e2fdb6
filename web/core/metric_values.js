// @ts-check
/*
 * Metric values as the web client handles them: null where a metric has no value, absent where the sender does not
 * know the metric. The wire and the summaries of recordings send NO_METRIC_VALUE for null.
 */

import { METRICS, NO_METRIC_VALUE } from "../messages.js";

/** @typedef {import("../messages.js").MetricKey} MetricKey */
/** @typedef {import("../messages.js").Metric} Metric */
/** @typedef {Partial<Record<MetricKey, number | null>>} MetricValues */
/** @typedef {Partial<Record<MetricKey, (number | null)[]>>} MetricCurves per metric its value after each tick */

/**
 * The metrics among the fields of a message.
 * @param {Partial<Record<MetricKey, number>>} fields
 * @returns {MetricValues}
 */
export function decodeValues(fields) {
  return collect(fields, decode);
}

/** @param {Partial<Record<MetricKey, number[]>>} curves @returns {MetricCurves} */
export function decodeCurves(curves) {
  return collect(curves, (metric, values) => values.map((value) => decode(metric, value)));
}

/** @param {Metric} metric @param {number} value */
function decode({ optional }, value) {
  return optional && value === NO_METRIC_VALUE ? null : value;
}

/**
 * @template From, To
 * @param {Partial<Record<MetricKey, From>>} given
 * @param {(metric: Metric, value: From) => To} convert
 * @returns {Partial<Record<MetricKey, To>>}
 */
function collect(given, convert) {
  /** @type {Partial<Record<MetricKey, To>>} */
  const found = {};
  for (const metric of METRICS) {
    const value = given[metric.key];
    if (value !== undefined) found[metric.key] = convert(metric, value);
  }
  return found;
}
