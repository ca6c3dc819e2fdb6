// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { decodeCurves, decodeValues } from "../../core/metric_values.js";

test("-1 is no value for a metric that may have none, and a number for the others", () => {
  const sent = { tcr: 0.5, nfd: -1, wt_s: 0, ac: -1, interdependence: 0 };
  assert.deepEqual(decodeValues(sent), { ...sent, ac: null });
});

test("of a message only the metrics are read; one that was not sent stays absent", () => {
  const message = { type: "result", ticks: 5, tcr: 1 };
  assert.deepEqual(decodeValues(message), { tcr: 1 });
});

test("curves are read tick by tick", () => {
  assert.deepEqual(decodeCurves({ nfd: [-1, 0], ac: [-1, 0.5] }), { nfd: [-1, 0], ac: [null, 0.5] });
});
