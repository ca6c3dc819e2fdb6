// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ENGLISH, TEXT } from "../../text/text.js";
import { GERMAN } from "../../text/text_de.js";

/**
 * Every sentence by its path; functions are called with something to put in.
 * @param {unknown} texts
 * @returns {Map<string, string>}
 */
function sentences(texts, path = "") {
  if (typeof texts === "function") return new Map([[path, texts("square", 7)]]);
  if (typeof texts !== "object" || texts === null) return new Map([[path, String(texts)]]);
  return new Map(Object.entries(texts).flatMap(([name, text]) => [...sentences(text, `${path}/${name}`)]));
}

test("outside a study the game speaks English", () => {
  assert.equal(TEXT, ENGLISH);
});

test("the German game has every sentence, none of them empty", () => {
  const german = sentences(GERMAN);
  assert.deepEqual([...german.keys()], [...sentences(ENGLISH).keys()]);
  assert.deepEqual(
    [...german].filter(([, text]) => text.trim() === ""),
    [],
  );
});

test("what is carried has its article in both languages", () => {
  assert.deepEqual(
    [ENGLISH.state.carrying("octagon"), GERMAN.state.carrying("octagon")],
    ["carrying an octagon", "trägt ein Achteck"],
  );
  assert.equal(GERMAN.state.carrying("heptagon"), "trägt etwas");
});
