// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { endsOf } from "../../questionnaire/radio.js";
import { speak } from "../text/support.js";

/** @param {object} part @returns {import("../../questionnaire/pages.js").Item} */
const item = (part) => /** @type {any} */ ({ id: "effort", label: "", text: "", ...part });

test("a scale without ends of its own has those of its kind, in the reader's language", () => {
  speak("de");
  assert.deepEqual(endsOf(item({ kind: "likert7" })), ["stimme gar nicht zu", "stimme völlig zu"]);
  assert.deepEqual(endsOf(item({ kind: "tlx" })), ["sehr gering", "sehr hoch"]);
  assert.deepEqual(endsOf(item({ kind: "tlx", ends: ["Perfekt", "Misserfolg"] })), ["Perfekt", "Misserfolg"]);
});
