// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError } from "../core/api.js";
import { missing, paginate } from "../study/forms/questionnaire_pages.js";
import { Persistence } from "../study/forms/persistence.js";
import { measureRtt, median } from "../study/input_check/rtt.js";
import { TriedControls } from "../study/input_check/tried_controls.js";
import { UnsentAnswers } from "../study/forms/unsent_answers.js";

/** @typedef {import("../study/forms/questionnaire_pages.js").Kind} Kind */
/** @param {string} id @param {Kind} kind @param {boolean} [required] */
const item = (id, kind, required) => ({ id, kind, label: id, text: id, required });

test("scales and choices share pages of three, each text has one of its own", () => {
  const pages = paginate([item("a", "choice"), item("b", "tlx"), item("c", "text"), item("d", "likert7")]);
  assert.deepEqual(
    pages.map((page) => page.map(({ id }) => id)),
    [["a", "b"], ["c"], ["d"]],
  );
});

test("what must be answered follows from the kind, unless the question says otherwise", () => {
  const page = [
    item("a", "choice"),
    item("b", "tlx", false),
    item("c", "text"),
    item("d", "text", true),
    item("e", "text", true),
  ];
  const answers = new Map([
    ["d", { value: -1, text: "  " }],
    ["e", { value: -1, text: "fine" }],
  ]);
  assert.deepEqual(
    missing(page, answers).map(({ id }) => id),
    ["a", "d"],
  );
});

test("a server that is away is asked ever later, a refusal is passed on at once", async () => {
  /** @type {number[]} */
  const waits = [];
  /** @type {boolean[]} */
  const states = [];
  const persistence = new Persistence(
    (offline) => states.push(offline),
    async (ms) => void waits.push(ms),
  );
  let tries = 0;
  const answer = await persistence.until(async () => {
    tries += 1;
    if (tries < 7) throw new ApiError("offline", "", tries === 3 ? 503 : 0);
    return "here";
  });
  assert.deepEqual([answer, waits, states.at(-1)], ["here", [500, 1000, 2000, 4000, 4000, 4000], false]);
  await assert.rejects(
    persistence.until(async () => Promise.reject(new ApiError("not_saved", "full", 507))),
    /full/,
  );
  assert.equal(waits.length, 6);
});

test("the round trip is the median of nine, after the two that open the connection", async () => {
  let clock = 0;
  const lengths = [900, 400, 20, 30, 25, 22, 500, 21, 24, 23, 26];
  let asked = 0;
  const rtt = await measureRtt(
    async () => void (clock += lengths[asked++]),
    () => clock,
  );
  assert.deepEqual([rtt, asked], [24, 11]);
  assert.equal(median([1, 4, 2, 3]), 2.5);
});

/** @param {Partial<import("../input/seats.js").SeatReading>} reading */
const pressed = (reading) => ({
  stick: { x: 0, y: 0 },
  backward: false,
  grabs: 0,
  device: /** @type {const} */ ("keyboard"),
  ...reading,
});

test("controls are tried when each direction and grab were pressed once; a stick at rest is nothing", () => {
  const tried = new TriedControls(false);
  assert.equal(tried.add(pressed({ stick: { x: 0.2, y: -0.2 } })), false);
  assert.equal(tried.add(pressed({ stick: { x: 0.7, y: 0.7 } })), true);
  assert.deepEqual(tried.todo, ["left", "down", "grab"]);
  tried.add(pressed({ stick: { x: -1, y: 0 } }));
  tried.add(pressed({ stick: { x: 0, y: -1 }, grabs: 1 }));
  assert.deepEqual(tried.todo, []);
});

test("where a gamepad is required, keys do not count", () => {
  const tried = new TriedControls(true);
  assert.equal(tried.add(pressed({ grabs: 1 })), false);
  assert.equal(tried.add(pressed({ grabs: 1, device: "gamepad" })), true);
});

test("unsent answers survive the page, belong to one form, and go when the newest has arrived", () => {
  /** @type {Map<string, string>} */
  const kept = new Map();
  const storage = {
    getItem: (/** @type {string} */ key) => kept.get(key) ?? null,
    setItem: (/** @type {string} */ key, /** @type {string} */ value) => void kept.set(key, value),
  };
  const answer = (/** @type {number} */ value) => ({ question: "teamwork", value, text: "", elapsed_ms: 5 });
  const before = new UnsentAnswers("P1 form", storage);
  before.add(answer(3));
  before.add(answer(5));
  before.remove(answer(3)); // an older click arrives: the newer one still waits
  assert.deepEqual(new UnsentAnswers("P1 form", storage).all(), [answer(5)]);
  assert.deepEqual(new UnsentAnswers("P2 form", storage).all(), []);
  before.remove(answer(5));
  assert.deepEqual(new UnsentAnswers("P1 form", storage).all(), []);
  kept.set("movingout-study-unsent", "not ours");
  assert.deepEqual(before.all(), []);
});
