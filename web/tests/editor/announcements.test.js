// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { placeText, turnText } from "../../editor/announcements.js";
import { addRect, emptyMap, movedTo, turnedTo } from "../../editor/parts.js";
import { setTexts } from "../../text/catalogue.js";
import { textsOf } from "../text/support.js";

const ITEM = /** @type {const} */ ({ kind: "items", index: 0 });
const WALL = /** @type {const} */ ({ kind: "walls", index: 0 });

test("where a part is and how it is turned is said in the reader's numbers", () => {
  setTexts("en", textsOf("en"));
  const walled = addRect(emptyMap("My map"), "walls", { x: -0.5, y: 0.3 }, { x: 0.5, y: 0.4 });
  assert.equal(placeText(movedTo(walled, ITEM, { x: 0.05, y: -0.4 }), ITEM), "x 0.05; y -0.40");
  assert.equal(placeText(movedTo(walled, ITEM, { x: -0.001, y: 0 }), ITEM), "x 0.00; y 0.00");
  assert.equal(placeText(walled, WALL), "Left -0.50; Bottom 0.30");
  assert.equal(turnText(walled, WALL), "Width 1.00; Height 0.10");
  assert.equal(turnText(turnedTo(walled, ITEM, Math.PI / 12), ITEM), "Angle in degrees 15");
  setTexts("de", textsOf("de"));
  assert.equal(placeText(walled, WALL), "Links -0,50; Unten 0,30");
  assert.equal(turnText(turnedTo(walled, ITEM, Math.PI / 12), ITEM), "Winkel in Grad 15");
});
