// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { keptName } from "../../annotate/annotator.js";

test("a kept name that the server would refuse is asked for again", () => {
  let kept = "";
  Object.defineProperty(globalThis, "localStorage", { value: { getItem: () => kept }, configurable: true });
  for (const [name, known] of [
    ["Anna O'Neil", "Anna O'Neil"],
    ["Zoë-2", "Zoë-2"],
    ["Anna/Bea", ""],
    ["a".repeat(41), ""],
    ["", ""],
  ]) {
    kept = name;
    assert.equal(keptName(), known);
  }
});
