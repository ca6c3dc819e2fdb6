// @ts-check
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

import { LANGUAGES } from "../text/language.js";

const WEB = new URL("../", import.meta.url);
const read = (/** @type {string} */ name) => readFileSync(new URL(name, WEB), "utf-8");

test("a browser that is too old is told so in every language", () => {
  const told = [...read("old_browser.js").matchAll(/^ {4}(\w+):$/gm)].map(([, language]) => language);
  assert.deepEqual(told, Object.keys(LANGUAGES));
});

test("no script has a pattern that looks behind, which stops a whole module in Safari before 16.4", () => {
  const scripts = readdirSync(WEB, { recursive: true }).map(String);
  const ours = scripts.filter((name) => name.endsWith(".js") && !name.startsWith("tests"));
  assert.deepEqual(
    ours.filter((name) => /\(\?<[=!]/.test(read(name))),
    [],
  );
});
