// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { filterChoices, filterRecordings, playerWords } from "../../replay/recordings_filter.js";
import { speak } from "../text/support.js";

/** @type {import("../../replay/recordings_filter.js").Row[]} */
const ROWS = [
  { id: "a", started: "", map: "HandOff", outcome: "time", blue: "human P1", red: "agent scripted", complete: true },
  {
    id: "b",
    started: "",
    map: "LeftRight",
    outcome: "delivered",
    blue: "agent scripted",
    red: "human P2",
    complete: true,
  },
  { id: "c", started: "", complete: false, damage: "c.mcap is empty" },
];
const ANY = { map: "", player: "", outcome: "" };

/** @param {Partial<typeof ANY>} filter */
const found = (filter) =>
  filterRecordings(ROWS, { ...ANY, ...filter })
    .map(({ id }) => id)
    .join("");

test("no filter keeps everything, damaged files too", () => {
  assert.equal(found({}), "abc");
});

test("a player is found in either seat", () => {
  assert.equal(found({ player: "agent scripted" }), "ab");
  assert.equal(found({ player: "human P2" }), "b");
});

test("filters narrow together", () => {
  assert.equal(found({ player: "agent scripted", outcome: "time" }), "a");
  assert.equal(found({ map: "HandOff", outcome: "delivered" }), "");
});

test("drawn maps of one name are chosen by their titles", () => {
  const drawn = ["My map", "Meine Karte", "My map"].map((title, index) => {
    return { id: `${index}`, started: "", map: "Map", title, complete: true };
  });
  const choices = filterChoices(drawn).map;
  assert.deepEqual(choices, ["Map Meine Karte", "Map My map"]);
  const ids = choices.map((map) => filterRecordings(drawn, { ...ANY, map }).map(({ id }) => id));
  assert.deepEqual(ids, [["1"], ["0", "2"]]);
});

test("the choices are what occurs, once, sorted", () => {
  assert.deepEqual(filterChoices(ROWS), {
    map: ["HandOff", "LeftRight"],
    player: ["agent scripted", "human P1", "human P2"],
    outcome: ["delivered", "time"],
  });
});

test("players are shown as people read them", () => {
  speak("en");
  assert.deepEqual(
    ["human P1", "agent bass@all", "human ", ""].map((player) => playerWords(player)),
    ["P1", "Trained partner (BASS) · bass@all", "A person", "–"],
  );
});
