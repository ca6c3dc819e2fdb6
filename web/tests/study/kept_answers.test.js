// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { UnsentAnswers } from "../../questionnaire/unsent_answers.js";
import { dropUnsentOf, keepUnsentOf, unsentName } from "../../study/kept_answers.js";

const [ANN, BEN, NEW] = ["token-of-ann", "token-of-ben", "token-of-new"];

/** A browser in which these have an answer that is not sent yet. @param {readonly string[]} tokens */
function browserOf(tokens) {
  /** @type {Map<string, string>} */
  const kept = new Map();
  const storage = {
    getItem: (/** @type {string} */ key) => kept.get(key) ?? null,
    setItem: (/** @type {string} */ key, /** @type {string} */ value) => void kept.set(key, value),
  };
  const unsent = (/** @type {string} */ token) => new UnsentAnswers(`${unsentName(token)} play/1/form`, storage);
  for (const token of tokens) unsent(token).add({ question: "why", value: -1, text: token, elapsed_ms: 5 });
  const texts = (/** @type {string} */ token) =>
    unsent(token)
      .all()
      .map(({ text }) => text);
  return { storage, found: () => ({ ann: texts(ANN), ben: texts(BEN), new: texts(NEW) }) };
}

test("who opens their link again finds the answers that were not sent, and their neighbour's wait", () => {
  const { storage, found } = browserOf([ANN, BEN]);
  keepUnsentOf([NEW], NEW, ANN, [BEN], storage);
  assert.deepEqual(found(), { ann: [], ben: [BEN], new: [ANN] });
});

test("the second at a screen comes back beside the first, or somebody else in their place", () => {
  const back = browserOf([ANN, BEN]);
  keepUnsentOf([ANN, NEW], NEW, BEN, [], back.storage);
  assert.deepEqual(back.found(), { ann: [ANN], ben: [], new: [BEN] });
  const another = browserOf([ANN, BEN]);
  keepUnsentOf([ANN, NEW], NEW, undefined, [], another.storage);
  assert.deepEqual(another.found(), { ann: [ANN], ben: [], new: [] });
});

test("whoever comes next finds none of those before, and who has finished leaves none", () => {
  const next = browserOf([ANN, BEN]);
  keepUnsentOf([NEW], NEW, undefined, [], next.storage);
  assert.deepEqual(next.found(), { ann: [], ben: [], new: [] });
  const finished = browserOf([ANN, BEN]);
  dropUnsentOf([ANN], finished.storage);
  assert.deepEqual(finished.found(), { ann: [], ben: [BEN], new: [] });
});
