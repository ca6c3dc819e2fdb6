// The drawing over time: what another tab has drawn is one step that can be undone.

import test from "node:test";
import assert from "node:assert/strict";

import { Drawing } from "../../editor/history.js";
import { emptyMap } from "../../editor/parts.js";

const [mine, theirs, later] = ["mine", "theirs", "later"].map(emptyMap);

test("what another tab draws in many steps is one step here", () => {
  const drawing = new Drawing(mine);
  assert.deepEqual([drawing.adopt(theirs), drawing.adopt(later)], [true, true]);
  assert.deepEqual([drawing.map, drawing.past], [later, [mine]]);
  drawing.undo();
  assert.equal(drawing.map, mine);
});

test("a change here lies between two of the other tab", () => {
  const drawing = new Drawing(mine);
  drawing.adopt(theirs);
  drawing.change(emptyMap("again mine"), "title");
  drawing.adopt(later);
  assert.deepEqual(
    drawing.past.map(({ title }) => title),
    ["mine", "theirs", "again mine"],
  );
});

test("what is the same, cannot be read or comes while a part is dragged is left alone", () => {
  const drawing = new Drawing(mine);
  assert.deepEqual([drawing.adopt(structuredClone(mine)), drawing.adopt(null)], [false, false]);
  drawing.preview(theirs);
  assert.equal(drawing.adopt(later), false);
  assert.equal(drawing.map, theirs);
});
