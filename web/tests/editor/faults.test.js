// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { faultText } from "../../editor/faults.js";
import { setTexts } from "../../text/catalogue.js";
import { textsOf } from "../text/support.js";

/** @param {string} path @param {string} code @param {Record<string, unknown>} [values] */
const german = (path, code, values = {}) => {
  setTexts("de", textsOf("de"));
  return faultText({ path, message: "in English", code, values });
};

test("a fault of a map written by hand is said in the reader's language, with its place in the file", () => {
  assert.equal(
    german("items[1].shape", "unknown_value", { value: '"blob"', known: ["star", "circle"] }),
    'items[1].shape: "blob" ist unbekannt. Möglich: star und circle.',
  );
  assert.equal(german("items[2]", "missing", { key: "mass" }), "items[2]: mass fehlt.");
  assert.equal(
    german("walls[1].y0", "out_of_range", { value: "3", least: -1.2, most: 1.2 }),
    "walls[1].y0: 3 liegt nicht zwischen -1,2 und 1,2.",
  );
  assert.equal(german("the map", "no_object"), "Die Karte: Hier muss ein Objekt stehen.");
});

test("a fault of a drawing names the part, as the page does", () => {
  assert.equal(
    german("items[1]", "in_wall", { other: "walls[0]" }),
    "Gegenstand 2 steht in Wand 1. Wände sind etwas dicker als gezeichnet.",
  );
});

test("a hint on a file names the part, and what to do here", () => {
  assert.equal(
    german("robots.blue.angle", "degrees", { angle: -90 }),
    "Roboter Blau: In der Datei steht der Winkel -90, im Bogenmaß. " +
      "Wenn Grad gemeint sind, geben Sie hier -90 als Winkel ein.",
  );
  assert.equal(
    german("items[0].angle", "degrees", { angle: 22.5 }),
    "Gegenstand 1: In der Datei steht der Winkel 22,5, im Bogenmaß. " +
      "Wenn Grad gemeint sind, geben Sie hier 22,5 als Winkel ein.",
  );
});

test("what no page has words for stays the checker's own", () => {
  assert.equal(german("items[1]", "of_a_newer_server"), "Gegenstand 2: in English");
});
