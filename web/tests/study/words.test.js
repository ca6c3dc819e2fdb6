// @ts-check
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

import { ApiError } from "../../core/api.js";
import { LANGUAGES, Words, pickLanguage } from "../../study/words.js";

const WEB = new URL("../../", import.meta.url);

/** @param {string} language @returns {Record<string, string>} */
const textsOf = (language) => JSON.parse(readFileSync(new URL(`words/study.${language}.json`, WEB), "utf-8"));
const english = textsOf("en");
const places = (/** @type {string} */ text) => [...text.matchAll(/\{\w+\}/g)].map(([place]) => place).sort();

for (const language of LANGUAGES) {
  test(`every text of the study exists in ${language}, with the same places for values`, () => {
    const texts = textsOf(language);
    assert.deepEqual(Object.keys(texts).sort(), Object.keys(english).sort());
    for (const [key, text] of Object.entries(texts)) assert.deepEqual(places(text), places(english[key]), key);
  });
}

test("every text that a page asks for by name exists, and no text is there for nothing", () => {
  const files = readdirSync(WEB, { recursive: true })
    .map(String)
    .filter((name) => /^(study\/.*|play\/play)\.js$/.test(name));
  const code = files.map((name) => readFileSync(new URL(name, WEB), "utf-8")).join("\n");
  const named = [...code.matchAll(/say\((?:[^"`()]*\? )?"([\w.-]+)"(?: : "([\w.-]+)")?/g)].flatMap(([, one, other]) => [
    one,
    other ?? one,
  ]);
  const built = [...code.matchAll(/`(\w+\.(?:\w+\.)?)\$\{[^}]+\}(\w*)`/g)].map(
    ([, start, end]) => new RegExp(`^${start.replaceAll(".", "\\.")}[\\w-]+${end}$`),
  );
  for (const key of named) assert.ok(key in english, `no text ${key}`);
  const used = (/** @type {string} */ key) =>
    named.includes(key) || code.includes(`"${key}"`) || built.some((one) => one.test(key));
  assert.deepEqual(
    Object.keys(english).filter((key) => !used(key)),
    [],
  );
});

test("values go into their places, and a text that does not exist is a fault", () => {
  const words = new Words("en", { greeting: "Part {done} of {total}" });
  assert.equal(words.say("greeting", { done: 3, total: 24 }), "Part 3 of 24");
  assert.throws(() => words.say("nothing"), /no text for nothing in en/);
});

test("a failure is said in our own words where there are any, else in the server's", () => {
  const words = new Words("de", { "error.slow": "Zu langsam." });
  assert.equal(words.problem(new ApiError("slow", "too slow", 422)), "Zu langsam.");
  assert.equal(words.problem(new ApiError("odd", "The disk is full.", 507)), "The disk is full.");
  assert.throws(() => words.problem(new TypeError("a bug")), TypeError);
});

test("times are minutes and seconds", () => {
  const words = new Words("en", {});
  assert.deepEqual(
    [0, 9.6, 65, 600, -3].map((seconds) => words.clock(seconds)),
    ["0:00", "0:10", "1:05", "10:00", "0:00"],
  );
});

test("the language is the first wish that is offered, also without its country, else the first offered", () => {
  assert.equal(pickLanguage(["en", "de"], [null, undefined, "de-AT", "en"]), "de");
  assert.equal(pickLanguage(["en", "de"], ["fr", "en-US"]), "en");
  assert.equal(pickLanguage(["de"], ["en"]), "de");
});
