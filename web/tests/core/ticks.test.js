// @ts-check
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";

import { clockText, POSE_MS, secondsOf, ticksOf } from "../../core/ticks.js";
import { LIMIT_TICKS, POSES_PER_TICK, TICK_MS } from "../../messages.js";

test("ticks, poses and seconds agree with the server's clock", () => {
  assert.equal(POSE_MS * POSES_PER_TICK, TICK_MS);
  assert.equal(ticksOf(1) * TICK_MS, 1000);
  assert.equal(secondsOf(ticksOf(50)), 50);
  assert.equal(secondsOf(LIMIT_TICKS), 50); // the label of this limit in the lobby
});

test("time is minutes and seconds, rounded up", () => {
  assert.deepEqual([50, 30.1, 9.9, 0, -1].map(clockText), ["0:50", "0:31", "0:10", "0:00", "0:00"]);
  assert.equal(clockText(125), "2:05");
});

test("no other module declares the length of a tick, of a pose or of a round", () => {
  const web = new URL("../../", import.meta.url);
  const declares = /const \w*(TICKS_PER_S|POSE_MS|TICK_MS|LIMIT_TICKS) = \d+;/;
  const sources = readdirSync(web, { recursive: true, encoding: "utf-8" }).filter((name) => name.endsWith(".js"));
  const found = sources.filter((name) => declares.test(readFileSync(new URL(name, web), "utf-8")));
  assert.deepEqual(found, ["messages.js"]);
});
