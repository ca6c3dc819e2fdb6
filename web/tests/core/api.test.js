// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError, contentOf, request, requestBlob, requestJson } from "../../core/api.js";

/** @param {Response | Promise<Response>} answer of the server */
const answers = (answer) => Object.assign(globalThis, { fetch: async () => answer });

/** An answer whose content breaks off. @param {Error} [why] */
function brokenOff(why = new TypeError("network error")) {
  const body = new ReadableStream({
    start(stream) {
      stream.enqueue(new TextEncoder().encode('{"maps": ['));
      stream.error(why);
    },
  });
  return new Response(body);
}

/** @param {unknown} error */
const isOffline = (error) => error instanceof ApiError && error.code === "offline" && error.status === 0;

test("an answer that breaks off, or is another's page, is as no answer", async () => {
  answers(Promise.reject(new TypeError("refused")));
  await assert.rejects(requestJson("/api/maps"), isOffline);
  answers(brokenOff());
  await assert.rejects(requestJson("/api/maps"), isOffline);
  answers(new Response("<!doctype html><title>Free Wi-Fi: log in</title>"));
  await assert.rejects(requestJson("/api/maps"), isOffline);
});

test("so is a file that breaks off", async () => {
  answers(brokenOff());
  await assert.rejects(requestBlob("/api/recordings/a/file"), isOffline);
  answers(brokenOff());
  await assert.rejects(contentOf(request("/api/recordings/a/poses"), "arrayBuffer"), isOffline);
});

test("what the page itself gave up stays given up", async () => {
  answers(brokenOff(new DOMException("given up", "AbortError")));
  await assert.rejects(requestJson("/api/maps"), { name: "AbortError" });
});

test("whole answers and refusals are what the server said", async () => {
  answers(Response.json({ maps: [1] }));
  assert.deepEqual(await requestJson("/api/maps"), { maps: [1] });
  answers(new Response("abc"));
  assert.equal(await (await requestBlob("/file")).text(), "abc");
  answers(Response.json({ error: { code: "no_room", message: "No.", values: {} } }, { status: 404 }));
  await assert.rejects(requestJson("/api/rooms/a"), { code: "no_room", status: 404 });
});
