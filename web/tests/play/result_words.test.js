// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { duration, headline, measures, percent } from "../../play/result_words.js";
import { speak } from "../text/support.js";

speak("en");

const RESULT = {
  index: 0,
  outcome: "time",
  ticks: 500,
  delivered: 3,
  items: 6,
  tcr: 0.571,
  nfd: 0.684,
  wt_s: 3.42,
  ac: 0.91,
  recording: "",
};

test("every outcome has a headline for people", () => {
  const outcomes = ["delivered", "time", "left", "stopped", "error"];
  assert.deepEqual(
    outcomes.map((outcome) => headline({ ...RESULT, outcome })),
    [
      "Everything is delivered!",
      "Time is up",
      "The round ended: a player left",
      "The round was stopped",
      "The round ended because of an error",
    ],
  );
});

test("durations are seconds below a minute and minutes above", () => {
  assert.deepEqual([0, 312, 599, 600, 1279].map(duration), ["0.0 s", "31.2 s", "59.9 s", "1 min 0 s", "2 min 8 s"]);
});

test("minutes never show sixty seconds", () => {
  assert.equal(duration(1197), "2 min 0 s");
});

test("the four measures carry the paper's short names", () => {
  assert.deepEqual(
    measures(RESULT).map(({ short, value }) => [short, value]),
    [
      ["TCR", "57 %"],
      ["NFD", "68 %"],
      ["WT", "3.4 s"],
      ["AC", "91 %"],
    ],
  );
});

test("nobody carried together is a dash, not minus one hundred per cent", () => {
  const consistency = measures({ ...RESULT, ac: -1 })[3];
  assert.deepEqual([consistency.value, consistency.help], ["–", "nothing was carried together"]);
});

test("items that ended farther away are said so", () => {
  const closer = measures({ ...RESULT, nfd: -0.126 })[1];
  assert.deepEqual([closer.value, closer.help], ["\u221213 %", "items ended farther from the goal"]);
  assert.equal(percent(-0.001), "0 %");
});
