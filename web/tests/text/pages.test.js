// @ts-check
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

import { LANGUAGES } from "../../text/language.js";

const WEB = new URL("../../", import.meta.url);
/** @type {Record<string, string>} */
const ENGLISH = JSON.parse(readFileSync(new URL("words/en.json", WEB), "utf-8"));
const PAGES = readdirSync(WEB, { recursive: true }).map(String);
const UNTIL_TEXTS = /<(\w+)[^>]* class="[^"]*\buntil-texts"[^>]*>.*?<\/\1>/gs;
const STYLE = readFileSync(new URL("styles/base.css", WEB), "utf-8");
const plain = (/** @type {string} */ html) => html.replaceAll("&amp;", "&").replace(/\s+/g, " ").trim();

for (const page of PAGES.filter((name) => name.endsWith(".html"))) {
  test(`${page} says in its source what the English catalogue says`, () => {
    const html = readFileSync(new URL(page, WEB), "utf-8");
    for (const [, key, text] of html.matchAll(/data-say="([\w.-]+)"[^>]*>([^<]*)</g)) {
      if (plain(text) !== "") assert.equal(plain(text), ENGLISH[key], key);
    }
  });

  test(`${page} has no words that only English readers understand`, () => {
    const html = readFileSync(new URL(page, WEB), "utf-8")
      .replace(/<(noscript|script|style)\b.*?<\/\1>/gs, "")
      .replace(UNTIL_TEXTS, "");
    const words = [...html.matchAll(/<(\w+)([^>]*)>([^<]*\p{L}{2}[^<]*)</gu)]
      .filter(([, , attributes]) => !/data-say=|data-theme-button|\bid="(play-all|now-help)"/.test(attributes))
      .map(([, , , text]) => plain(text));
    assert.deepEqual(
      words.filter((text) => text !== "Moving Out Live"),
      [],
    );
  });

  test(`${page} tells every reader that it needs scripts, if it does nothing without them`, () => {
    const html = readFileSync(new URL(page, WEB), "utf-8");
    const told = [...(html.match(/<noscript>.*?<\/noscript>/s)?.[0] ?? "").matchAll(/<span lang="(\w+)">/g)];
    const languages = page === "404.html" ? [] : Object.keys(LANGUAGES);
    assert.deepEqual(
      told.map(([, language]) => language),
      languages,
    );
  });

  test(`${page} tells the reader of a browser that is too old, before its program`, () => {
    const html = readFileSync(new URL(page, WEB), "utf-8");
    const [told, program] = [html.indexOf("/static/old_browser.js"), html.indexOf('type="module"')];
    assert.equal(told !== -1 && told < program, page !== "404.html"); // which has words alone
  });

  test(`${page} says what it says before its texts have loaded in every language`, () => {
    const html = readFileSync(new URL(page, WEB), "utf-8");
    const words = [...html.matchAll(UNTIL_TEXTS)].map(([element]) => element);
    if (words.length === 0) return;
    const languages = Object.keys(LANGUAGES);
    assert.ok(html.includes(`first_language.js" data-languages="${languages.join(" ")}"`));
    for (const element of words)
      assert.deepEqual(
        [...element.matchAll(/<span lang="(\w+)">/g)].map(([, language]) => language),
        languages,
      );
    for (const language of languages)
      assert.ok(STYLE.includes(`[data-first-language="${language}"] .until-texts > :not([lang="${language}"])`));
  });
}
