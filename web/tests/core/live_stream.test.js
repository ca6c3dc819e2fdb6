// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { EventLines, LiveStream } from "../../core/live_stream.js";

test("events come out whole, however the stream is cut", () => {
  const stream = ': beat\n\ndata: {"a":1}\n\ndata: {"b":\ndata: 2}\r\n\r\nevent: x\ndata:3\n\n';
  for (const size of [1, 3, 7, 1000]) {
    const lines = new EventLines();
    const pieces = stream.match(new RegExp(`[^]{1,${size}}`, "g")) ?? [];
    assert.deepEqual(
      pieces.flatMap((piece) => lines.push(piece)).map((data) => JSON.parse(data)),
      [{ a: 1 }, { b: 2 }, 3],
    );
  }
});

test("what is not complete yet is kept back", () => {
  const lines = new EventLines();
  assert.deepEqual(lines.push('data: {"a":1}\n'), []);
  assert.deepEqual(lines.push("\n"), ['{"a":1}']);
});

test("the token goes in a header, news reach the listener, and a refused stream stays closed", async (context) => {
  /** @type {[string, string | null][]} */
  const asked = [];
  const answers = [new Response('data: {"view":7}\n\n'), new Response("", { status: 401 })];
  context.mock.method(
    globalThis,
    "fetch",
    async (/** @type {string} */ path, /** @type {{headers: Record<string, string>}} */ { headers }) => {
      asked.push([path, headers.Authorization]);
      return answers.shift();
    },
  );
  context.mock.timers.enable({ apis: ["setTimeout"] });
  /** @type {unknown[]} */
  const heard = [];
  const stream = new LiveStream("/api/study/events", "secret", { onNews: (news) => heard.push(news) }).open();
  const turns = async () => {
    for (let turn = 0; turn < 20; turn += 1) await new Promise((done) => setImmediate(done));
  };
  await turns();
  context.mock.timers.tick(1000);
  await turns();
  context.mock.timers.tick(60_000);
  await turns();
  stream.close();
  assert.deepEqual(heard, [{ view: 7 }]);
  assert.deepEqual(asked, [
    ["/api/study/events", "Bearer secret"],
    ["/api/study/events", "Bearer secret"],
  ]);
});
