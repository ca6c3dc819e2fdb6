// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError } from "../../core/api.js";
import { lastingStorage, requireStorage } from "../../core/browser_storage.js";

/** @param {() => unknown} get what naming a storage does */
function storages(get) {
  for (const name of ["localStorage", "sessionStorage"])
    Object.defineProperty(globalThis, name, { get, configurable: true });
}

test("the browser's own storage is used where it may be", () => {
  const own = { getItem: () => "kept", setItem() {} };
  storages(() => own);
  assert.equal(lastingStorage(), own);
  requireStorage();
});

test("where even naming it throws, texts last as long as the page, and what needs another page says so", () => {
  storages(() => {
    throw new DOMException("denied", "SecurityError");
  });
  assert.equal(lastingStorage().getItem("a"), null);
  lastingStorage().setItem("a", "1");
  assert.equal(lastingStorage().getItem("a"), "1");
  assert.throws(requireStorage, (error) => error instanceof ApiError && error.code === "storage");
});
