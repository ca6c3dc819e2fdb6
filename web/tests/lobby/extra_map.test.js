// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { cardOf, extraMap, queryFor, takeListed } from "../../lobby/extra_map.js";

/** @typedef {import("../../view/render.js").GameMap} GameMap */

/** @param {string} name @param {string} [variant] @returns {GameMap} */
const mapOf = (name, variant) => ({
  ...{ name, title: name, number: 0, mode: "practice", description: "", walls: [], goals: [], items: [] },
  robots: { blue: { x: 0, y: 0, angle: 0 }, red: { x: 1, y: 0, angle: 0 } },
  ...(variant && { variant }),
});
const ANNAS = { ...mapOf("MyMap"), goals: [{ x0: 0, y0: 0, x1: 1, y1: 1 }] };
const OFFERED = { shipped: [mapOf("HandOff")], own: [ANNAS] };

/** The page at /?map=NAME, after a round on `played`. @param {string} name @param {GameMap | null} played */
function arrive(name, played) {
  const values = {
    location: { search: `?map=${name}` },
    sessionStorage: { getItem: () => JSON.stringify(played) },
    fetch: (/** @type {string} */ path) => Promise.resolve(Response.json({ asked: path })),
  };
  for (const [key, value] of Object.entries(values))
    Object.defineProperty(globalThis, key, { value, configurable: true });
  return extraMap(OFFERED);
}

test("a listed map needs no place of its own, played or not, its items shuffled or not", async () => {
  assert.equal(await arrive("", mapOf("Other")), null);
  assert.equal(await arrive("MyMap", null), null);
  assert.equal(await arrive("MyMap", ANNAS), null);
  assert.equal(await arrive("HandOff", { ...mapOf("HandOff", "challenge2-train-7"), items: [] }), null);
});

test("the map just played is offered where none of its name is listed, or one that is another drawing", async () => {
  for (const played of [mapOf("Other"), mapOf("MyMap")])
    assert.deepEqual(await arrive(played.name, played), { map: played, key: "lobby.played" });
});

test("the map just played has a card beside one of the operator's with its name", () => {
  const map = mapOf("MyMap");
  assert.deepEqual(
    [cardOf({ map, key: "lobby.played" }), cardOf({ map, key: "lobby.linked" })],
    ["played:MyMap", "MyMap"],
  );
});

test("the address for another language says which one of two drawings of a name was chosen", () => {
  const chosen = { map: "MyMap", seed: null };
  void arrive("MyMap&lang=de", null);
  assert.deepEqual(
    [queryFor(chosen, true), queryFor(chosen, false), queryFor(null, true)],
    ["?map=MyMap&listed=yes", "?map=MyMap", "?map=MyMap&listed=yes"],
  );
});

test("which one it was is read once, and is then no longer in the address that people copy", () => {
  void arrive("MyMap&listed=yes&seed=7", null);
  Object.assign(globalThis.location, { pathname: "/", hash: "#partner" });
  const shown = /** @type {unknown[]} */ ([]);
  const history = { state: null, replaceState: (/** @type {unknown[]} */ ...to) => void shown.push(to.at(-1)) };
  Object.defineProperty(globalThis, "history", { value: history, configurable: true });
  assert.deepEqual([takeListed(), shown], [true, ["/?map=MyMap&seed=7#partner"]]);
  void arrive("MyMap&seed=7", null);
  assert.deepEqual([takeListed(), shown.length], [false, 1]);
});

test("a shipped name is the shipped map, whatever was played: an earlier drawing, or a rounded start", async () => {
  const robots = { ...mapOf("HandOff").robots, red: { x: 1.001, y: 0, angle: 0 } };
  assert.equal(await arrive("HandOff", { ...mapOf("HandOff"), robots }), null);
  assert.equal(await arrive("HandOff", { ...mapOf("HandOff", "imported"), walls: ANNAS.goals }), null);
});

test("any other map the server knows by its name", async () => {
  const linked = { map: { asked: "/api/maps/HandOff%3Amirror" }, key: "lobby.linked" };
  assert.deepEqual(await arrive("HandOff:mirror", null), linked);
  assert.deepEqual(await arrive("HandOff:mirror", mapOf("HandOff:mirror", "challenge2-train-7")), linked);
});
