// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { Drawing, keptMap } from "../../editor/history.js";
import * as parts from "../../editor/parts.js";
import { added, gestureAt, handlesOf, partUnder } from "../../editor/pointing.js";

/** @typedef {import("../../editor/parts.js").Part} Part */

/** @type {Part} */
const WALL = { kind: "walls", index: 0 };
/** @type {Part} */
const ITEM = { kind: "items", index: 0 };
/** @type {Part} */
const BLUE = { kind: "robots", index: 0 };
const SELECT = /** @type {const} */ ({ tool: "select", shape: "star", size: "large", snap: true });

const room = () => parts.addRect(parts.emptyMap("Room"), "walls", { x: -0.2, y: -0.2 }, { x: 0.4, y: 0 });

test("a title makes a name that a map may have", () => {
  assert.equal(parts.nameOf("Die große Garage, 2. Stock"), "DieGrosseGarage2Stock");
  assert.equal(parts.nameOf("Überraschung é"), "UberraschungE");
  assert.equal(parts.nameOf("2 doors"), "Map2Doors");
  assert.equal(parts.nameOf("Anna’s – map"), "AnnaSMap");
  assert.equal(parts.nameOf("a".repeat(60)).length, 40);
});

test("a sign that is no letter, digit, picture or arrow is left out of the name and adds nothing to it", () => {
  assert.equal(parts.nameOf("20° turn"), "Map20Turn");
  assert.equal(parts.nameOf("A – B"), "AB");
  assert.equal(parts.nameOf("½ way"), "Map12Way");
  assert.equal(parts.nameOf("a\u200db"), "AB");
  assert.notEqual(parts.nameOf("🇫🇷"), parts.nameOf("🇩🇪"));
});

test("titles that differ in letters which no name has make different names", () => {
  const titles = ["地図", "Карта Маши", "Карта Миши", "Χάρτης", "خريطة", "🐱", "🐶", "Map", "Łódź", "Odz", "Комната 2"];
  titles.push("длинное название ".repeat(5), `${"длинное название ".repeat(5)}два`);
  const names = titles.map(parts.nameOf);
  assert.equal(new Set(names).size, titles.length);
  for (const name of names) assert.match(name, /^[A-Za-z][A-Za-z0-9-]{0,39}$/);
  assert.match(parts.nameOf(`${"a".repeat(60)} 地図`), /^Aa{31,}-[a-z0-9]{1,7}$/);
  assert.equal(parts.nameOf("Карта й "), parts.nameOf("Карта й".normalize("NFD")));
});

test("titles that differ in their arrows make different names", () => {
  const titles = ["A → B", "A ← B", "A ↔ B", "A ⇒ B", "A ⟶ B", "A ⤴ B", "A ⬆ B", "A B"];
  const names = titles.map(parts.nameOf);
  assert.equal(new Set(names).size, titles.length);
  for (const name of names) assert.match(name, /^AB(-[a-z0-9]{1,7})?$/);
});

test("a drawn rectangle has an area and stays inside, whatever the pointer does", () => {
  const map = parts.addRect(room(), "goals", { x: 5, y: -5 }, { x: 5, y: -5 });
  const { left, bottom, right, top } = parts.sides(map.goals[1]);
  assert.ok(right - left >= 0.02 && top - bottom >= 0.02);
  assert.ok(left >= -1.2 && right <= 1.2 && bottom >= -1.2 && top <= 1.2);
});

test("moving keeps a wall's size and stops at the edge of the arena", () => {
  const map = parts.movedTo(room(), WALL, { x: 2, y: -2 });
  assert.deepEqual(parts.sides(map.walls[0]), { left: 0.6, bottom: -1.2, right: 1.2, top: -1 });
  const back = parts.movedBy(parts.movedBy(room(), WALL, 0.1, -0.05), WALL, -0.1, 0.05);
  assert.deepEqual(back.walls, room().walls);
});

test("a wall turns by a quarter about its middle, and four times is none", () => {
  const once = parts.turnedTo(room(), WALL, 1);
  assert.deepEqual(parts.sides(once.walls[0]), { left: 0, bottom: -0.4, right: 0.2, top: 0.2 });
  const twice = parts.turnedTo(once, WALL, 1);
  assert.deepEqual(parts.sides(twice.walls[0]), parts.sides(room().walls[0]));
});

test("items get the radius and mass of their size, an id of their own, and there are seven at most", () => {
  let map = parts.removed(room(), ITEM);
  for (const size of ["small", "large", "middle", "small", "small", "small", "small", "small"])
    map = parts.addItem(map, "star", size, { x: 0, y: 0.3 });
  assert.equal(map.items.length, 7);
  assert.deepEqual(
    map.items.slice(0, 3).map(({ id, scale, mass }) => [id, scale, mass]),
    [
      [0, 0.06, 0.1],
      [1, 0.17, 0.5],
      [2, 0.11, 0.5],
    ],
  );
  assert.equal(parts.duplicated(map, ITEM), map, "there is no room for another one");
});

test("a copy has an id of its own and lies beside", () => {
  const map = parts.duplicated(room(), ITEM);
  assert.deepEqual(
    map.items.map(({ id }) => id),
    [0, 1],
  );
  for (const size of ["small", "large"]) {
    const [one, copy] = parts.duplicated(parts.resized(room(), ITEM, size), ITEM).items;
    assert.ok(Math.hypot(copy.x - one.x, copy.y - one.y) >= 2 * one.scale, `${size} ones do not overlap`);
  }
});

test("robots are moved and turned but neither deleted nor doubled", () => {
  const map = room();
  assert.equal(parts.removed(map, BLUE), map);
  assert.equal(parts.duplicated(map, BLUE), map);
  assert.deepEqual(parts.movedTo(map, BLUE, { x: 0.1, y: 3 }).robots.blue, { x: 0.1, y: 1.2, angle: 0 });
  assert.equal(parts.turnedTo(map, BLUE, 2.5 * Math.PI).robots.blue.angle, 1.571);
});

test("paths lead to parts and back", () => {
  for (const part of parts.partsOf(room())) assert.deepEqual(parts.partAt(parts.pathOf(part)), part);
  assert.deepEqual(parts.partAt("items[3].scale"), { kind: "items", index: 3 });
  for (const path of ["goals", "name", "the map", ""]) assert.equal(parts.partAt(path), null);
});

test("undo goes back step by step, redo forward, and a new step forgets what was undone", () => {
  const drawing = new Drawing(room());
  const first = drawing.map;
  drawing.change(parts.movedBy(drawing.map, WALL, 0.1, 0));
  const second = drawing.map;
  drawing.change(parts.removed(drawing.map, WALL));
  drawing.undo();
  assert.equal(drawing.map, second);
  drawing.undo();
  drawing.undo();
  assert.equal(drawing.map, first);
  drawing.redo();
  assert.equal(drawing.map, second);
  drawing.change(parts.turnedTo(drawing.map, WALL, 1));
  drawing.redo();
  assert.notEqual(drawing.map, second, "nothing to redo any more");
});

test("letters of one field are one step, a drag is one step, a drag called off is none", () => {
  const drawing = new Drawing(room());
  const first = drawing.map;
  for (const title of ["A", "Ab", "Abc"]) drawing.change({ ...drawing.map, title }, "title");
  assert.equal(drawing.past.length, 1);
  for (const x of [0.1, 0.2, 0.3]) drawing.preview(parts.movedBy(first, WALL, x, 0));
  drawing.settle();
  assert.equal(drawing.past.length, 2);
  const settled = drawing.map;
  drawing.preview(first);
  drawing.cancel();
  assert.equal(drawing.map, settled);
  assert.equal(drawing.past.length, 2);
});

test("what is selected is forgotten when it is gone", () => {
  const drawing = new Drawing(room());
  drawing.select(WALL);
  drawing.change(parts.removed(drawing.map, WALL));
  assert.equal(drawing.selected, null);
});

test("only what looks like a map is taken from the browser's memory", () => {
  assert.deepEqual(keptMap(JSON.stringify(room())), room());
  const broken = [null, "", "{", "null", "{}", "[]", JSON.stringify({ ...room(), walls: [{ x0: 1 }] })];
  broken.push(JSON.stringify({ ...room(), robots: { blue: null } }), JSON.stringify({ ...room(), items: [{}] }));
  for (const text of broken) assert.equal(keptMap(text), null, String(text));
});

test("robots and items lie above walls, and small things are found from beside", () => {
  const map = parts.movedTo(room(), BLUE, { x: 0, y: -0.1 });
  assert.deepEqual(partUnder(map, { x: 0.05, y: -0.1 }, 0.05), BLUE);
  assert.deepEqual(partUnder(map, { x: 0.35, y: -0.1 }, 0.05), WALL);
  assert.deepEqual(partUnder(map, { x: 0.08, y: 0.05 }, 0.1), ITEM);
  assert.equal(partUnder(map, { x: -1, y: 0.3 }, 0.05), null);
});

test("a drag moves a part along the grid, a click only selects it", () => {
  const map = room();
  const drag = gestureAt(map, null, { x: 0.35, y: -0.1 }, SELECT, 0.05);
  assert.ok(drag);
  assert.deepEqual(drag({ x: 0.35, y: -0.1 }), { map, selected: WALL });
  assert.deepEqual(parts.sides(drag({ x: 0.46, y: -0.07 }).map.walls[0]), {
    left: -0.1,
    bottom: -0.15,
    right: 0.5,
    top: 0.05,
  });
});

test("a corner of a selected wall is drawn out, the opposite one stays", () => {
  const drag = gestureAt(room(), WALL, { x: 0.4, y: 0 }, SELECT, 0.05);
  assert.ok(drag);
  assert.deepEqual(parts.sides(drag({ x: 0.71, y: 0.19 }).map.walls[0]), {
    left: -0.2,
    bottom: -0.2,
    right: 0.7,
    top: 0.2,
  });
});

test("the handle of an item turns it in steps, another one makes it larger", () => {
  const map = room();
  const [turn, size] = handlesOf(map, ITEM);
  const turning = gestureAt(map, ITEM, turn, SELECT, 0.05);
  assert.ok(turning);
  assert.equal(turning({ x: -0.5, y: 0.02 }).map.items[0].angle, 1.571);
  const sizing = gestureAt(map, ITEM, size, SELECT, 0.01);
  assert.ok(sizing);
  assert.equal(sizing({ x: 0.16, y: 0 }).map.items[0].scale, 0.12);
});

test("a small item that is selected is still moved by its middle, however broad the finger", () => {
  const drag = gestureAt(room(), ITEM, { x: 0.02, y: -0.02 }, SELECT, 0.2);
  assert.ok(drag);
  const [item] = drag({ x: 0.32, y: 0.23 }).map.items;
  assert.deepEqual([item.x, item.y, item.scale, item.angle], [0.3, 0.25, 0.06, 0]);
});

test("tools draw by dragging, by a click and without a pointer", () => {
  const map = room();
  const wall = gestureAt(map, null, { x: -1, y: 0.5 }, { ...SELECT, tool: "wall" }, 0.05);
  assert.ok(wall);
  assert.deepEqual(parts.sides(wall({ x: -0.52, y: 0.61 }).map.walls[1]), {
    left: -1,
    bottom: 0.5,
    right: -0.5,
    top: 0.6,
  });
  assert.deepEqual(parts.sides(wall({ x: -1, y: 0.5 }).map.walls[1]), {
    left: -1.2,
    bottom: 0.45,
    right: -0.6,
    top: 0.55,
  });
  const item = added(map, { ...SELECT, tool: "item" }, { x: 0, y: 0 });
  assert.deepEqual([item.map.items[1].shape, item.map.items[1].size], ["star", "large"]);
  assert.deepEqual(item.selected, { kind: "items", index: 1 });
});
