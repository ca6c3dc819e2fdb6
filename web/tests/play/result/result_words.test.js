// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import {
  bestText,
  duration,
  headline,
  howItEnded,
  measures,
  outcomeText,
  percent,
} from "../../../play/result/result_words.js";
import { METRICS } from "../../../messages.js";
import { LANGUAGES } from "../../../text/language.js";
import { speak, textsOf } from "../../text/support.js";

speak("en");

const VALUES = { tcr: 0.571, nfd: 0.684, wt_s: 3.42, ac: 0.91 };

test("every outcome has a headline for people", () => {
  const outcomes = ["delivered", "time", "left", "stopped", "error"];
  assert.deepEqual(
    outcomes.map((outcome) => outcomeText({ outcome })),
    [
      "Everything is delivered!",
      "Time is up",
      "The round ended because a player left",
      "The round was stopped",
      "The round ended because of an error",
    ],
  );
});

test("the result says what was delivered, to whoever played and to whoever watched", () => {
  assert.equal(headline({ delivered: 4, items: 6 }, true), "You delivered 4 of 6");
  assert.equal(headline({ delivered: 6, items: 6 }, true), "You delivered everything!");
  assert.equal(headline({ delivered: 4, items: 6 }), "4 of 6 delivered");
  assert.equal(howItEnded({ outcome: "delivered", ticks: 312 }), "It took 31.2 s.");
  assert.equal(howItEnded({ outcome: "time", ticks: 500 }), "Time is up.");
  assert.equal(howItEnded({ outcome: "left", ticks: 5 }, true), "You stopped the round.");
  assert.equal(howItEnded({ outcome: "left", ticks: 5 }), "The round ended because a player left.");
  assert.equal(howItEnded({ outcome: "left", ticks: 5 }, false, "Red did not come back."), "Red did not come back.");
  assert.equal(howItEnded({ outcome: "left", ticks: 5 }, true, "Blue left the game."), "You stopped the round.");
  assert.equal(howItEnded({ outcome: "time", ticks: 500 }, false, "Everybody is back."), "Time is up.");
});

test("a result is compared with the best before it", () => {
  const result = { outcome: "time", delivered: 4, items: 6, ticks: 500 };
  assert.equal(bestText(result, null), "");
  assert.equal(bestText(result, { delivered: 5, ticks: 500 }), "Best so far in this browser: 5 of 6.");
  assert.equal(bestText(result, { delivered: 3, ticks: 500 }), "That is the best so far in this browser.");
  const all = { outcome: "delivered", delivered: 6, items: 6, ticks: 300 };
  assert.equal(bestText(all, { delivered: 6, ticks: 280 }), "Fastest so far in this browser: 28.0 s.");
  assert.equal(bestText(all, { delivered: 6, ticks: 400 }), "That is the best so far in this browser.");
});

test("durations are seconds below a minute and minutes above", () => {
  assert.deepEqual([0, 312, 599, 600, 1279].map(duration), ["0.0 s", "31.2 s", "59.9 s", "1 min 0 s", "2 min 8 s"]);
});

test("minutes never show sixty seconds", () => {
  assert.equal(duration(1197), "2 min 0 s");
});

test("every metric has its texts in every language", () => {
  for (const language of Object.keys(LANGUAGES)) {
    const texts = textsOf(language);
    for (const { key, low, optional } of METRICS) {
      const variants = ["", ".help", ...(low === null ? [".negative"] : []), ...(optional ? [".none"] : [])];
      for (const variant of variants) assert.ok(texts[`play.measure.${key}${variant}`], `${language} ${key}${variant}`);
    }
  }
});

test("the metrics that were sent are shown under their short names, in the order of the table", () => {
  assert.deepEqual(
    measures(VALUES).map(({ metric, value }) => [metric.symbol, value]),
    [
      ["TCR", "57 %"],
      ["NFD", "68 %"],
      ["WT", "3.4 s"],
      ["AC", "91 %"],
    ],
  );
});

test("a metric without a value is a dash", () => {
  const consistency = measures({ ...VALUES, ac: null })[3];
  assert.deepEqual([consistency.value, consistency.help], ["–", "nothing was carried together"]);
});

test("items that ended farther away are said so", () => {
  const closer = measures({ ...VALUES, nfd: -0.126 })[1];
  assert.deepEqual([closer.value, closer.help], ["\u221213 %", "items ended farther from the green area"]);
  assert.equal(percent(-0.001), "0 %");
});
