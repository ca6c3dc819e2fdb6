// @ts-check
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

const WEB = new URL("../../", import.meta.url);
/** @type {Record<string, string>} */
const ENGLISH = JSON.parse(readFileSync(new URL("words/en.json", WEB), "utf-8"));
const PAGES = readdirSync(WEB, { recursive: true }).map(String);
const plain = (/** @type {string} */ html) => html.replaceAll("&amp;", "&").replace(/\s+/g, " ").trim();

for (const page of PAGES.filter((name) => name.endsWith(".html"))) {
  test(`${page} says in its source what the English catalogue says`, () => {
    const html = readFileSync(new URL(page, WEB), "utf-8");
    for (const [, key, text] of html.matchAll(/data-say="([\w.-]+)"[^>]*>([^<]*)</g)) {
      if (plain(text) !== "") assert.equal(plain(text), ENGLISH[key], key);
    }
  });
}
