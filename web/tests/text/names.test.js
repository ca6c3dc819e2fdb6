// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { mapDescription, mapTitle } from "../../text/names.js";
import { speak } from "./support.js";

test("a map has the title of the catalogue, else its own, else its name in words", () => {
  speak("en");
  assert.equal(mapTitle({ name: "HandOff" }), "Hand Off");
  assert.equal(mapTitle({ name: "MyLab", title: "The lab" }), "The lab");
  assert.equal(mapTitle({ name: "TwoDoorsAhead" }), "Two Doors Ahead");
});

test("a mirrored or turned map says so in its title", () => {
  speak("en");
  assert.equal(mapTitle({ name: "HandOff:mirror" }), "Hand Off, mirrored");
  assert.equal(mapTitle({ name: "HandOff:mirror:rot90", title: "HO" }), "Hand Off, mirrored, turned 90°");
  assert.equal(mapTitle({ name: "MyLab:rot270", title: "The lab" }), "The lab, turned 270°");
  assert.match(mapDescription({ name: "HandOff:rot180", description: "?" }), /narrow pathway/);
});
