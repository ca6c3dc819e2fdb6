import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

import { roundTripPill } from "../../components/dashboard.js";
import { roundTripTone } from "../../core/round_trip.js";
import { connectionWords } from "../../play/seat_phrases.js";
import { speak } from "../text/support.js";

speak("en");

test("a link is good below 80 ms and bad from 200 ms", () => {
  const tones = [0, 79.9, 80, 199.9, 200, 900].map(roundTripTone);
  assert.deepEqual(tones, ["ok", "ok", "attention", "attention", "bad", "bad"]);
});

test("a link has the colour for its player that it has for the experimenter", () => {
  for (const ms of [20, 90, 150, 220, 300]) {
    assert.equal(connectionWords("open", false, ms).state, roundTripTone(ms));
    assert.equal(roundTripPill(ms).tone, roundTripTone(ms));
  }
});

test("the check before a study has no limits of its own", () => {
  const check = readFileSync(new URL("../../study/input_check/input_check.js", import.meta.url), "utf8");
  assert.match(check, /roundTripTone\(this\.#rtt\)/);
  assert.doesNotMatch(check, /rtt\)?\s*[<>]=?\s*\d|\d\s*[<>]=?\s*(this\.#)?rtt/);
});
