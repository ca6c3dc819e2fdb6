// @ts-check
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { difficulty } from "../../lobby/difficulty.js";

const MAPS = fileURLToPath(new URL("../../../maps/", import.meta.url));

/** @param {string} name @returns {import("../../view/render.js").GameMap} */
const load = (name) => JSON.parse(readFileSync(`${MAPS}${name}.json`, "utf-8"));

test("room to move and light items are easy; a corridor, or a large item to be steered around a wall, is hard", () => {
  const levels = Object.fromEntries(
    ["Simple", "DistancePriority", "LeftRight", "EfficientRoutes", "HandOff", "SingleRotation"].map((name) => [
      name,
      difficulty(load(name)),
    ]),
  );
  assert.deepEqual(levels, {
    Simple: 1,
    DistancePriority: 1,
    LeftRight: 2,
    EfficientRoutes: 2,
    HandOff: 3,
    SingleRotation: 3,
  });
});

test("the shipped maps are spread over all three levels", () => {
  const names = readdirSync(MAPS).filter((file) => file.endsWith(".json") && !file.endsWith(".schema.json"));
  const levels = names.map((file) => difficulty(load(file.replace(".json", ""))));
  for (const level of [1, 2, 3]) assert.ok(levels.filter((one) => one === level).length >= 2, `${level}: ${levels}`);
});
