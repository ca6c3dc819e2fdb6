// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { readLayout } from "../../input/keyboard_layout.js";
import { DEFAULTS, withKey } from "../../input/mapping.js";
import { defaultPartner, parseSeed, roomRequest, seatOptions, seatRequest, seatsNote } from "../../lobby/choice.js";
import { speak } from "../text/support.js";

speak("en");

/** @param {string | null} mapping */
const kept = (mapping) => ({ getItem: () => mapping });

const AGENTS = [
  { id: "idle", name: "Idle", description: "Stands still." },
  { id: "scripted", name: "Scripted", description: "Helps." },
  { id: "bass@all", name: "BASS", description: "Learned." },
];
/** @type {import("../../lobby/choice.js").Choice} */
const CHOICE = { map: "HandOff", seats: ["here", "agent:bass@all"], limitTicks: 500, seed: 7 };

test("a choice becomes the body of POST /api/rooms", () => {
  assert.deepEqual(roomRequest(CHOICE, ["HandOff", "LeftRight"]), {
    maps: ["HandOff", "LeftRight"],
    limit_ticks: 500,
    practice: false,
    challenge2_seed: 7,
    seats: [{ kind: "here" }, { kind: "agent", agent: "bass@all" }],
  });
});

test("a seat with the proposed partner is left to the server, and one with another agent is not", () => {
  const { seats } = roomRequest(CHOICE, ["HandOff"], false, "agent:bass@all");
  assert.deepEqual(seats, [{ kind: "here" }, { kind: "partner" }]);
  assert.deepEqual(seatRequest("agent:idle", "agent:bass@all"), { kind: "agent", agent: "idle" });
  assert.deepEqual(seatRequest("link", "link"), { kind: "link" });
});

test("practice has neither limit nor changed items", () => {
  const body = roomRequest(CHOICE, ["Simple"], true);
  assert.deepEqual([body.practice, body.limit_ticks, body.challenge2_seed], [true, 0, null]);
});

test("every seat option is a request", () => {
  for (const { value } of seatOptions(AGENTS)) assert.ok(seatRequest(value).kind);
  assert.throws(() => seatRequest("sofa"), RangeError);
});

test("an agent is described in one sentence", () => {
  const [agent] = seatOptions([{ id: "a", name: "A", description: "Helps, e.g.\u00a0here. Has options." }]).filter(
    ({ group }) => group === "Computer partners",
  );
  assert.equal(agent.help, "Helps, e.g.\u00a0here.");
});

test("the first partner is the server's, else scripted, else whoever moves, else a person", () => {
  assert.equal(defaultPartner(AGENTS, "bass@all"), "agent:bass@all");
  assert.equal(defaultPartner(AGENTS), "agent:scripted");
  assert.equal(defaultPartner(AGENTS.slice(2)), "agent:bass@all");
  assert.equal(defaultPartner(AGENTS.slice(0, 1)), "link");
});

test("two people at one screen are told their keys, and who does not play what happens", () => {
  assert.match(
    seatsNote(["here", "here"], false, kept(null)),
    /blue on W A S D with Space and red on ↑ ← ↓ → with Enter/,
  );
  assert.match(
    seatsNote(["here", "here"], true, kept(null)),
    /red needs a keyboard, with ↑ ← ↓ → and Enter, or a gamepad/,
  );
  assert.match(seatsNote(["link", "agent:idle"]), /links/);
  assert.match(seatsNote(["agent:idle", "agent:scripted"]), /watch/);
  assert.equal(seatsNote(["here", "link"]), "");
});

test("two people at one screen are told the keys that they chose, as printed on their keyboard", async () => {
  const own = withKey(withKey(structuredClone(DEFAULTS), 0, "grab", "KeyE"), 1, "up", "Numpad8");
  await readLayout({ getLayoutMap: async () => new Map(Object.entries({ KeyW: "z", KeyA: "q" })) });
  const note = seatsNote(["here", "here"], false, kept(JSON.stringify(own)));
  await readLayout({ getLayoutMap: async () => new Map() });
  assert.match(note, /blue on Z Q S D with E and red on Num 8 ← ↓ → with Enter/);
});

test("a seed is one to nine digits", () => {
  assert.deepEqual(["0", " 42 ", "999999999"].map(parseSeed), [0, 42, 999999999]);
  assert.deepEqual(["", "-1", "1.5", "seven", "1234567890"].map(parseSeed), [null, null, null, null, null]);
});
