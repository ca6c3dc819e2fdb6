// @ts-check
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

import { ApiError } from "../../core/api.js";
import { has, say, sayError, sayNumber, setTexts, unmarked } from "../../text/catalogue.js";
import { LANGUAGES, pickLanguage } from "../../text/language.js";
import { textsOf } from "./support.js";

const WEB = new URL("../../", import.meta.url);
const english = textsOf("en");
const places = (/** @type {string} */ text) => [...new Set(text.match(/\{\w+\}/g))].sort();
const stem = (/** @type {string} */ key) => key.replace(/\.(zero|one|two|few|many|other)$/, "");
/** "a.one" and "a.other" are one text, in as many forms as the language has. @param {Record<string, string>} texts */
const keysOf = (texts) => [...new Set(Object.keys(texts).map(stem))];

for (const language of Object.keys(LANGUAGES)) {
  test(`every text exists in ${language}, with the same places for values`, () => {
    const texts = textsOf(language);
    assert.deepEqual(keysOf(texts).sort(), keysOf(english).sort());
    for (const [key, text] of Object.entries(texts)) {
      const model = english[key] ?? english[key.replace(/\.\w+$/, ".other")];
      if (!key.endsWith(".one")) assert.deepEqual(places(text), places(model), key); // "one" may be a word
    }
  });
}

test("no line begins with an ellipsis: in German it stands apart from its word, by a space that does not break", () => {
  const texts = Object.keys(LANGUAGES).flatMap((language) => Object.entries(textsOf(language)));
  assert.deepEqual(
    texts.filter(([, text]) => text.includes(" …")),
    [],
  );
});

test("German texts call a key what it is called everywhere else", () => {
  const texts = Object.entries(textsOf("de"));
  assert.deepEqual(
    texts.filter(([, text]) => /\b(Enter|Shift|Space|Delete)\b/.test(text)),
    [],
  );
});

test("every key in the code and the pages has a text, and no text is there for nothing", () => {
  const files = readdirSync(WEB, { recursive: true })
    .map(String)
    .filter((name) => /\.(js|html)$/.test(name) && !name.startsWith("tests"));
  const code = files.map((name) => readFileSync(new URL(name, WEB), "utf-8")).join("\n");
  const pages = keysOf(english).map((key) => key.split(".")[0]);
  const known = new Set(keysOf(english));
  const named = new Set(
    [...code.matchAll(/"([a-z]+)(\.[\w-]+)+"/g)]
      .filter(([, page]) => pages.includes(page))
      .map(([key]) => key.slice(1, -1)),
  );
  const used = new Set([...named].map(stem));
  const built = [...code.matchAll(/`([a-z]+\.(?:[\w-]+\.)*)\$\{[^`]*\}([\w.-]*)`/g)].map(
    ([, start, end]) => new RegExp(`^${start.replaceAll(".", "\\.")}.+${end.replaceAll(".", "\\.")}$`),
  );
  assert.deepEqual(
    [...named].filter((key) => !known.has(stem(key))),
    [],
  );
  assert.deepEqual(
    [...known].filter((key) => !used.has(key) && !built.some((shape) => shape.test(key))),
    [],
  );
});

test("values go into their places, numbers as the language writes them; an unknown key is a fault", () => {
  setTexts("de", { greeting: "Teil {done} von {total}" });
  assert.equal(say("greeting", { done: 3, total: 12_500 }), "Teil 3 von 12.500");
  assert.equal(sayNumber(0.5, 2), "0,50");
  assert.throws(() => say("nothing"), /no text for nothing in de/);
});

test("a list is written as the language does", () => {
  setTexts("de", { lost: "Es fehlen: {players}" });
  assert.equal(say("lost", { players: ["Blau", "Rot"] }), "Es fehlen: Blau und Rot");
});

test("a count chooses the plural form", () => {
  setTexts("en", { "left.one": "one left", "left.other": "{count} left" });
  assert.deepEqual([say("left", { count: 1 }), say("left", { count: 0 })], ["one left", "0 left"]);
  assert.deepEqual([has("left"), has("right")], [true, false]);
});

test("a refusal is said by its code, else in the server's words", () => {
  setTexts("de", { "error.slow": "Zu langsam: {ms} ms." });
  assert.equal(sayError(new ApiError("slow", "too slow", 422, { ms: 300 })), "Zu langsam: 300 ms.");
  assert.equal(sayError(new ApiError("odd", "The disk is full.", 507)), "The disk is full.");
  assert.throws(() => sayError(new TypeError("a bug")), TypeError);
  const full = new ApiError("full", "All 2 rooms are in use.", 503, { refusal: "rooms_in_use", rooms: 2 });
  setTexts("de", { "error.full": "Voll.", "refusal.rooms_in_use": "Alle {rooms} Räume sind belegt." });
  assert.equal(sayError(full), "Alle 2 Räume sind belegt.");
  assert.equal(sayError(new ApiError("full", "Full.", 503, { refusal: "new_one" })), "Voll.");
});

test("the language is the first wish that is offered, also without its country, else the first offered", () => {
  assert.equal(pickLanguage(["en", "de"], [null, undefined, "de-AT", "en"]), "de");
  assert.equal(pickLanguage(["en", "de"], ["fr", "en-US"]), "en");
  assert.equal(pickLanguage(["de"], ["en"]), "de");
  assert.equal(pickLanguage(["de", "en-GB"], ["en-US", "de"]), "en-GB", "one of another country is understood");
  assert.equal(pickLanguage(["en", "de", "de-AT"], ["de-AT"]), "de-AT");
  assert.equal(pickLanguage(["en", "de-AT"], ["de"]), "de-AT");
});

test("a name that is written from the right has its own direction within a sentence, and is kept without marks", () => {
  setTexts("en", { "a.b": "{name}: {count}" });
  assert.equal(say("a.b", { name: "חדר 3", count: 4 }), "\u2068חדר 3\u2069: 4");
  assert.equal(say("a.b", { name: "\u2068חדר 3\u2069", count: 4 }), "\u2068חדר 3\u2069: 4", "not twice");
  assert.equal(say("a.b", { name: "Room 3", count: 4 }), "Room 3: 4");
  assert.equal(unmarked(say("a.b", { name: "חדר 3", count: 4 })), "חדר 3: 4");
});
