// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { AnswerQueue } from "../../questionnaire/answer_queue.js";

/** @param {number} value */
const answer = (value, question = "teamwork") => ({ question, value, text: "", elapsed_ms: 1 });
const offline = () => Object.assign(new Error("no connection"), { status: 0 });
const refusal = () => Object.assign(new Error("teamwork takes 1 to 7"), { status: 422 });

/** @param {(answer: {question: string, value: number}) => Promise<void>} send */
function queueWith(send) {
  /** @type {number[]} */
  const waits = [];
  /** @type {import("../../questionnaire/answer_queue.js").SaveState[]} */
  const states = [];
  const queue = new AnswerQueue(
    send,
    (state) => states.push(state),
    async (ms) => void waits.push(ms),
  );
  return { queue, waits, states };
}

test("answers are sent one after the other in the order given", async () => {
  /** @type {string[]} */
  const sent = [];
  const { queue } = queueWith(async ({ question }) => void sent.push(question));
  queue.add(answer(5));
  queue.add(answer(6, "humanlike"));
  await queue.settled();
  assert.deepEqual(sent, ["teamwork", "humanlike"]);
  assert.deepEqual(queue.state, { waiting: 0, failure: null, refused: null });
});

test("an answer that cannot be sent is tried again, ever later, until it arrives", async () => {
  let tries = 0;
  const { queue, waits, states } = queueWith(async () => {
    tries += 1;
    if (tries < 7) throw offline();
  });
  queue.add(answer(5));
  await queue.settled();
  assert.equal(tries, 7);
  assert.deepEqual(waits, [1000, 2000, 4000, 8000, 8000, 8000]);
  assert.ok(states.some(({ failure, waiting }) => failure instanceof Error && waiting === 1));
  assert.deepEqual(queue.state, { waiting: 0, failure: null, refused: null });
});

test("of several answers to one question given while offline only the newest is sent", async () => {
  /** @type {number[]} */
  const tried = [];
  let online = false;
  const { queue } = queueWith(async ({ value }) => {
    tried.push(value);
    if (!online) throw offline();
  });
  queue.later = async () => void (online = true);
  queue.add(answer(2));
  queue.add(answer(3));
  queue.add(answer(4));
  await queue.settled();
  assert.deepEqual(tried, [2, 4]);
});

test("a newer answer given while the older one is on its way is sent too", async () => {
  /** @type {number[]} */
  const sent = [];
  const { queue } = queueWith(async ({ value }) => {
    sent.push(value);
    if (value === 2) queue.add(answer(6));
  });
  queue.add(answer(2));
  await queue.settled();
  assert.deepEqual(sent, [2, 6]);
});

test("a refusal is not repeated and is kept until the next answer", async () => {
  const error = refusal();
  let tries = 0;
  const { queue } = queueWith(async () => {
    tries += 1;
    if (tries === 1) throw error;
  });
  queue.add(answer(9));
  await queue.settled();
  assert.deepEqual(queue.state, { waiting: 0, failure: null, refused: error });
  queue.add(answer(7));
  await queue.settled();
  assert.deepEqual([tries, queue.state.refused], [2, null]);
});

test("retryNow ends a wait that would still last", async () => {
  let online = false;
  const { queue } = queueWith(async () => {
    if (!online) throw offline();
  });
  queue.later = () => new Promise(() => {}); // for ever
  queue.add(answer(5));
  await new Promise((done) => setImmediate(done));
  assert.notEqual(queue.state.failure, null);
  online = true;
  queue.retryNow();
  await queue.settled();
  assert.equal(queue.state.waiting, 0);
});
