// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { isLoopback } from "../../components/link.js";

test("a loopback address is one that only this machine opens", () => {
  const local = ["http://localhost:8000/play/x", "http://127.0.0.1/", "https://127.3.2.1:1/", "http://[::1]:8000/"];
  assert.deepEqual(local.map(isLoopback), [true, true, true, true]);
  const others = [
    "http://192.168.1.7:8000/",
    "https://play.example.org/",
    "http://127.example.org/",
    "http://[fe80::1]/",
  ];
  assert.deepEqual(others.map(isLoopback), [false, false, false, false]);
});
