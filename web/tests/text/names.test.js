// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { mapTitle } from "../../text/names.js";
import { speak } from "./support.js";

test("a map has the title of the catalogue, else its own, else its name in words", () => {
  speak("en");
  assert.equal(mapTitle({ name: "HandOff" }), "Hand Off");
  assert.equal(mapTitle({ name: "MyLab", title: "The lab" }), "The lab");
  assert.equal(mapTitle({ name: "TwoDoorsAhead" }), "Two Doors Ahead");
});
