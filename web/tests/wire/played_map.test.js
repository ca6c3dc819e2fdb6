// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { keepPlayed, keptPlayed, seedOf, wantedMap } from "../../wire/played_map.js";

/** @typedef {import("../../view/render.js").GameMap} GameMap */

const ROBOTS = { blue: { x: 0, y: 0, angle: 0 }, red: { x: 1, y: 0, angle: 0 } };
const TURNED = { ...ROBOTS, red: { x: 1, y: 0, angle: 1 } };
/** @type {GameMap} */
const DRAWN = {
  name: "MyMap",
  title: "My map",
  number: 0,
  mode: "practice",
  description: "",
  robots: ROBOTS,
  walls: [],
  goals: [],
  items: [{ id: 0, shape: "star", size: "small", scale: 0.06, mass: 0.1, x: 0, y: 0, angle: 0 }],
};

/** @param {Pick<Storage, "getItem" | "setItem"> | null} storage null: it is forbidden */
function useStorage(storage) {
  const get = () => {
    if (storage === null) throw new DOMException("forbidden", "SecurityError");
    return storage;
  };
  Object.defineProperty(globalThis, "sessionStorage", { get, configurable: true });
}

/** @param {string} name @param {Partial<GameMap>} [parts] @returns {GameMap} */
const mapOf = (name, parts = {}) => ({ ...DRAWN, name, ...parts });
const OFFERED = { shipped: [mapOf("b")], own: [mapOf("a")] };
const WALL = { x0: 0, y0: 0, x1: 1, y1: 1 };

test("a drawn map, which the server does not keep, is sent along; any other goes by its name", () => {
  const drawn = mapOf("MyMap");
  assert.deepEqual(wantedMap(drawn, "MyMap", OFFERED), { maps: [], map: drawn });
  const seed = { challenge2_seed: null };
  assert.deepEqual(wantedMap(drawn, "a", OFFERED), { maps: ["a"], ...seed });
  assert.deepEqual(wantedMap(mapOf("b"), "b", OFFERED), { maps: ["b"], ...seed });
  assert.deepEqual(wantedMap(mapOf("a:mirror"), "a:mirror", OFFERED), { maps: ["a:mirror"], ...seed });
});

test("a drawn map of the name of one of the operator's is sent along as well, unless it is the same drawing", () => {
  for (const other of [{ walls: [WALL] }, { goals: [WALL] }, { items: [] }, { robots: TURNED }]) {
    const drawn = mapOf("a", other);
    assert.deepEqual(wantedMap(drawn, "a", OFFERED), { maps: [], map: drawn });
  }
  assert.deepEqual(wantedMap(mapOf("a", { title: "Mine" }), "a", OFFERED), { maps: ["a"], challenge2_seed: null });
});

test("a shipped name is sent as a name, whatever was played: the server takes no drawing of it", () => {
  for (const played of [mapOf("b", { robots: TURNED }), mapOf("b", { variant: "imported", walls: [WALL] })])
    assert.deepEqual(wantedMap(played, "b", OFFERED), { maps: ["b"], challenge2_seed: null });
});

test("shuffled items stay shuffled by the same number, on this map and on the next", () => {
  const shuffled = mapOf("a", { variant: "challenge2-train-77", items: [], robots: TURNED });
  assert.deepEqual(wantedMap(shuffled, "a", OFFERED), { maps: ["a"], challenge2_seed: 77 });
  assert.deepEqual(wantedMap(shuffled, "b", OFFERED), { maps: ["b"], challenge2_seed: 77 });
  const drawn = { ...shuffled, walls: [WALL] };
  for (const offered of [{ ...OFFERED, own: [] }, OFFERED])
    assert.deepEqual(wantedMap(drawn, "a", offered), { maps: [], map: drawn }, "a drawn one is as it is");
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
