// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { METRICS } from "../../messages.js";
import { HEIGHT, WIDTH, pathOf, placeOf, scaleOf, tickAtPart } from "../../replay/metric_curves.js";
import { speak } from "../text/support.js";

speak("en");

/** @param {string} key @param {(number | null)[]} values */
function scale(key, values) {
  const metric = METRICS.find((one) => one.key === key);
  assert.ok(metric);
  return scaleOf(metric, values);
}

test("shares reach from 0 to 1, NFD below where it was, waiting up to its largest", () => {
  assert.deepEqual(scale("tcr", [0.2]), { low: 0, high: 1 });
  assert.deepEqual(scale("interdependence", [null, 0.5]), { low: 0, high: 1 });
  assert.deepEqual(scale("nfd", [0.1, -0.3]), { low: -0.3, high: 1 });
  assert.deepEqual(scale("wt_s", [0, 7.5]), { low: 0, high: 7.5 });
  assert.deepEqual(scale("wt_s", [0, 0]), { low: 0, high: 1 });
});

test("a curve runs from the first tick to the last, from the bottom to the top", () => {
  assert.equal(pathOf([0, 1], { low: 0, high: 1 }), `M${WIDTH / 2}.0 ${HEIGHT - 2}.0L${WIDTH}.0 2.0`);
});

test("a curve has a gap where there is no value, and none at minus one", () => {
  assert.equal(pathOf([null, 0, 1, null, 1], { low: 0, high: 1 }).replace(/[\d. ]+/g, ""), "MLM");
  assert.equal(pathOf([-1, -1], { low: -1, high: 1 }).replace(/[\d. ]+/g, ""), "ML");
  assert.equal(pathOf([null, null], { low: 0, high: 1 }), "");
});

test("a place on a curve and its tick belong together", () => {
  assert.equal(placeOf(25, 100), WIDTH / 4);
  assert.deepEqual(
    [-0.2, 0, 0.25, 1, 1.4].map((part) => tickAtPart(part, 100)),
    [0, 0, 25, 100, 100],
  );
});
