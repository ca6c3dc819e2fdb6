// What a browser keeps of the drawing: each tab its own map, and all tabs the one that was drawn last.

import test, { beforeEach } from "node:test";
import assert from "node:assert/strict";

import { keep, keepHere, keptHere, keptLast } from "../../editor/memory.js";
import { emptyMap } from "../../editor/parts.js";

const [one, two, later] = ["one", "two", "later"].map(emptyMap);

/** @param {"localStorage" | "sessionStorage"} name @param {Map<string, string> | null} texts null: it is forbidden */
function useStorage(name, texts) {
  const get = () => {
    if (texts === null) throw new DOMException("forbidden", "SecurityError");
    return {
      getItem: (/** @type {string} */ key) => texts.get(key) ?? null,
      setItem: (/** @type {string} */ key, /** @type {string} */ text) => void texts.set(key, text),
    };
  };
  Object.defineProperty(globalThis, name, { get, configurable: true });
}

/** @returns {() => void} goes to this tab */
function newTab() {
  const texts = new Map();
  const go = () => useStorage("sessionStorage", texts);
  go();
  return go;
}

beforeEach(() => useStorage("localStorage", new Map()));

test("a tab that is loaded again has its own map, although another tab has drawn another one since", () => {
  const first = newTab();
  keep("1", one);
  newTab();
  keep("2", two);
  assert.deepEqual(
    [keptHere(), keptLast()],
    [
      { which: "2", map: two },
      { which: "2", map: two },
    ],
  );
  first();
  assert.deepEqual(
    [keptHere(), keptLast()],
    [
      { which: "1", map: one },
      { which: "2", map: two },
    ],
  );
});

test("what another tab has drawn of the same map is newer than what this tab had", () => {
  const first = newTab();
  keep("1", one);
  newTab();
  keep("1", later);
  first();
  assert.deepEqual(keptHere(), { which: "1", map: later });
});

test("a new tab begins with what was drawn last, and keeps it without drawing", () => {
  newTab();
  keep("1", one);
  newTab();
  assert.deepEqual(keptHere(), { which: "1", map: one });
  keepHere("1", one);
  const second = keptHere();
  useStorage("localStorage", new Map());
  keepHere("2", two);
  assert.deepEqual([second, keptHere(), keptLast().map], [{ which: "1", map: one }, { which: "2", map: two }, null]);
});

test("where storage is forbidden, or is not ours, there is none", () => {
  newTab();
  useStorage("localStorage", new Map([["movingout.editor", "{}"]]));
  assert.deepEqual(keptHere(), { which: "", map: null });
  useStorage("localStorage", null);
  useStorage("sessionStorage", null);
  keep("1", one);
  assert.deepEqual(
    [keptHere(), keptLast()],
    [
      { which: "", map: null },
      { which: "", map: null },
    ],
  );
});
