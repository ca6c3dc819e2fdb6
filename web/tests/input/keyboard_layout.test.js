// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { printedOn, readLayout } from "../../input/keyboard_layout.js";
import { DEFAULTS, keyName, moveName } from "../../input/mapping.js";
import { speak } from "../text/support.js";

speak("en");

test("the keys are called what is printed on them, on a French and a German keyboard", async () => {
  assert.equal(moveName(DEFAULTS.keys[0]), "W A S D");
  await readLayout({ getLayoutMap: () => Promise.reject(new DOMException("forbidden", "SecurityError")) });
  await readLayout({});
  assert.equal(moveName(DEFAULTS.keys[0]), "W A S D", "where the browser does not tell");
  const printed = { KeyW: "z", KeyA: "q", KeyS: "s", KeyD: "d", Digit1: "&", Slash: "!", Minus: "ß" };
  await readLayout({ getLayoutMap: async () => new Map(Object.entries(printed)) });
  assert.equal(moveName(DEFAULTS.keys[0]), "Z Q S D");
  assert.deepEqual(["Slash", "Digit1", "Minus", "Space", "ArrowUp"].map(keyName), ["!", "1", "ß", "Space", "↑"]);
  assert.equal(printedOn("Quote"), "", "a key that the browser leaves out");
});
