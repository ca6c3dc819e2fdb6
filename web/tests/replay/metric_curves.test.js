// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { HEIGHT, WIDTH, pathOf, placeOf, scaleOf, tickAtPart } from "../../replay/metric_curves.js";
import { speak } from "../text/support.js";

speak("en");

test("shares reach from 0 to 1, NFD below where it was, waiting up to its largest", () => {
  assert.deepEqual(scaleOf("tcr", [0.2]), { low: 0, high: 1 });
  assert.deepEqual(scaleOf("nfd", [0.1, -0.3]), { low: -0.3, high: 1 });
  assert.deepEqual(scaleOf("wt_s", [0, 7.5]), { low: 0, high: 7.5 });
  assert.deepEqual(scaleOf("wt_s", [0, 0]), { low: 0, high: 1 });
});

test("a curve runs from the first tick to the last, from the bottom to the top", () => {
  assert.equal(pathOf([0, 1], { low: 0, high: 1 }), `M${WIDTH / 2}.0 ${HEIGHT - 2}.0L${WIDTH}.0 2.0`);
});

test("where nothing is carried together yet the curve has a gap", () => {
  assert.equal(pathOf([-1, 0, 1, -1, 1], { low: 0, high: 1 }).replace(/[\d. ]+/g, ""), "MLM");
  assert.equal(pathOf([-1, -1], { low: 0, high: 1 }), "");
});

test("a place on a curve and its tick belong together", () => {
  assert.equal(placeOf(25, 100), WIDTH / 4);
  assert.deepEqual(
    [-0.2, 0, 0.25, 1, 1.4].map((part) => tickAtPart(part, 100)),
    [0, 0, 25, 100, 100],
  );
});
