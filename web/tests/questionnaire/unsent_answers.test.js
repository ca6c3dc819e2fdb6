// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { UnsentAnswers, renameUnsent } from "../../questionnaire/unsent_answers.js";

/** @param {Map<string, string>} kept */
const storageOf = (kept) => ({
  getItem: (/** @type {string} */ key) => kept.get(key) ?? null,
  setItem: (/** @type {string} */ key, /** @type {string} */ value) => void kept.set(key, value),
});

const answer = (/** @type {number} */ value) => ({ question: "teamwork", value, text: "", elapsed_ms: 5 });

test("unsent answers survive the page, belong to one form, and go when the newest has arrived", () => {
  /** @type {Map<string, string>} */
  const kept = new Map();
  const storage = storageOf(kept);
  const before = new UnsentAnswers("P1 form", storage);
  before.add(answer(3));
  before.add(answer(5));
  before.remove(answer(3)); // an older click arrives: the newer one still waits
  assert.deepEqual(new UnsentAnswers("P1 form", storage).all(), [answer(5)]);
  assert.deepEqual(new UnsentAnswers("P2 form", storage).all(), []);
  before.remove(answer(5));
  assert.deepEqual(new UnsentAnswers("P1 form", storage).all(), []);
  kept.set("movingout-study-unsent", "not ours");
  assert.deepEqual(before.all(), []);
});

test("unsent answers follow who gave them to another name, and are dropped where there is none", () => {
  const storage = storageOf(new Map());
  const of = (/** @type {string} */ form) => new UnsentAnswers(form, storage);
  of("old play/1/form").add(answer(3));
  of("gone play/1/form").add(answer(4));
  renameUnsent((name) => (name === "old" ? "new" : null), storage);
  assert.deepEqual(of("new play/1/form").all(), [answer(3)]);
  assert.deepEqual([...of("old play/1/form").all(), ...of("gone play/1/form").all()], []);
});

test("a text that is refused for good stays as it was typed and is not sent again; a choice is made anew", () => {
  const storage = storageOf(new Map());
  const form = new UnsentAnswers("P1 form", storage);
  const typed = { question: "why", value: -1, text: "Because.", elapsed_ms: 5 };
  for (const one of [typed, answer(9)]) {
    form.add(one);
    form.refuse(one);
  }
  const again = new UnsentAnswers("P1 form", storage);
  assert.deepEqual([again.all(), again.refused().map(({ text }) => text)], [[], ["Because."]]);
  again.add({ ...typed, text: "Therefore." });
  again.refuse(typed); // an older one: the newer one still waits
  assert.deepEqual([again.all().map(({ text }) => text), again.refused()], [["Therefore."], []]);
});
