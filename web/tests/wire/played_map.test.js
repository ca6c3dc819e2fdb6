// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { keepPlayed, keptPlayed, wantedMap } from "../../wire/played_map.js";

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
  assert.deepEqual(wantedMap(drawn, "a", ["a", "b"]), { maps: ["a"] });
  assert.deepEqual(wantedMap({ name: "b" }, "b", ["a", "b"]), { maps: ["b"] });
  assert.deepEqual(wantedMap({ name: "a:mirror" }, "a:mirror", ["a", "b"]), { maps: ["a:mirror"] });
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
