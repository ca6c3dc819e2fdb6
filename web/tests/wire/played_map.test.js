// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { keepPlayed, keptPlayed, seedOf, wantedMap } from "../../wire/played_map.js";

const DRAWN = /** @type {import("../../view/render.js").GameMap} */ (
  /** @type {unknown} */ ({ name: "MyMap", title: "My map", walls: [], goals: [], items: [] })
);

/** @param {Pick<Storage, "getItem" | "setItem"> | null} storage null: it is forbidden */
function useStorage(storage) {
  const get = () => {
    if (storage === null) throw new DOMException("forbidden", "SecurityError");
    return storage;
  };
  Object.defineProperty(globalThis, "sessionStorage", { get, configurable: true });
}

test("a drawn map, which the server does not keep, is sent along; any other goes by its name", () => {
  const drawn = { name: "MyMap" };
  assert.deepEqual(wantedMap(drawn, "MyMap", ["a", "b"]), { maps: [], map: drawn });
  const seed = { challenge2_seed: null };
  assert.deepEqual(wantedMap(drawn, "a", ["a", "b"]), { maps: ["a"], ...seed });
  assert.deepEqual(wantedMap({ name: "b" }, "b", ["a", "b"]), { maps: ["b"], ...seed });
  assert.deepEqual(wantedMap({ name: "a:mirror" }, "a:mirror", ["a", "b"]), { maps: ["a:mirror"], ...seed });
});

test("shuffled items stay shuffled by the same number, on this map and on the next", () => {
  const shuffled = { name: "a", variant: "challenge2-train-77" };
  assert.deepEqual(wantedMap(shuffled, "a", ["a", "b"]), { maps: ["a"], challenge2_seed: 77 });
  assert.deepEqual(wantedMap(shuffled, "b", ["a", "b"]), { maps: ["b"], challenge2_seed: 77 });
  assert.deepEqual(wantedMap(shuffled, "a", ["b"]), { maps: [], map: shuffled }, "a drawn one is as it is");
  assert.deepEqual([seedOf({}), seedOf({ variant: "challenge2-evaluation-7" })], [null, null]);
});

test("the map that was just played is there for the page after it, by its name", () => {
  /** @type {Map<string, string>} */
  const kept = new Map();
  useStorage({ getItem: (key) => kept.get(key) ?? null, setItem: (key, text) => void kept.set(key, text) });
  assert.equal(keptPlayed("MyMap"), null);
  keepPlayed(DRAWN);
  assert.deepEqual(keptPlayed("MyMap"), DRAWN);
  assert.equal(keptPlayed("Another"), null);
  kept.forEach((_, key) => kept.set(key, '{"name": "MyMap"}'));
  assert.equal(keptPlayed("MyMap"), null, "something else under our key");
});

test("where storage is forbidden nothing is kept, and nothing fails", () => {
  useStorage(null);
  keepPlayed(DRAWN);
  assert.equal(keptPlayed("MyMap"), null);
});
