// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { givenAnswers, missing, paginate, positionOf, resumePage } from "../../questionnaire/pages.js";

/** @type {import("../../questionnaire/pages.js").Item[]} */
const ITEMS = [
  ...[..."abcdefghi"].map((id) => ({ id, kind: /** @type {const} */ ("likert7"), label: id, text: id })),
  { id: "comment", kind: "text", label: "Comment", text: "What else?" },
];
const PAGES = paginate(ITEMS);

/** @param {string} ids */
const answered = (ids) => new Map([...ids].map((id) => [id, { value: 4, text: "" }]));

test("nine scales make three pages of three and the text has its own", () => {
  assert.deepEqual(
    PAGES.map((page) => page.map(({ id }) => id).join("")),
    ["abc", "def", "ghi", "comment"],
  );
});

test("no page is left with a single scale where the others have three", () => {
  assert.deepEqual(
    [1, 2, 3, 4, 5, 7, 8, 9].map((count) => paginate(ITEMS.slice(0, count)).map((page) => page.length)),
    [[1], [2], [3], [2, 2], [3, 2], [3, 2, 2], [3, 3, 2], [3, 3, 3]],
  );
});

test("a page's position counts questions over the whole questionnaire", () => {
  assert.deepEqual(
    [1, 3].map((page) => positionOf(PAGES, page)),
    [
      { first: 4, last: 6, total: 10, count: 3 },
      { first: 10, last: 10, total: 10, count: 1 },
    ],
  );
});

test("a scale is missing until it is answered, a text never is", () => {
  assert.deepEqual(
    missing(PAGES[0], answered("b")).map(({ id }) => id),
    ["a", "c"],
  );
  assert.deepEqual(missing(PAGES[3], answered("")), []);
});

test("a reload goes on at the first page with something missing, else at the last", () => {
  assert.equal(resumePage(PAGES, answered("")), 0);
  assert.equal(resumePage(PAGES, answered("abcdf")), 1);
  assert.equal(resumePage(PAGES, answered("abcdefghi")), 3);
});

test("texts alone, which may all stay empty, begin at the first and go on where somebody was", () => {
  const texts = paginate([..."abc"].map((id) => item(id, "text")));
  assert.deepEqual(
    ["", "a", "b", "abc"].map((ids) => resumePage(texts, answered(ids))),
    [0, 0, 1, 2],
  );
});

test("no page that nobody has seen is left out because it may stay empty", () => {
  const pages = paginate([item("a", "text"), item("b", "likert7"), item("c", "likert7", false), item("d", "text")]);
  assert.deepEqual(
    ["", "a", "ab", "abc", "bcd"].map((ids) => resumePage(pages, answered(ids))),
    [0, 0, 1, 2, 2],
  );
});

test("what the server kept is taken over and anything else ignored", () => {
  const kept = givenAnswers({ a: { value: 3, text: "" }, comment: { value: -1, text: "fine" }, odd: "?" });
  assert.deepEqual(
    [...kept],
    [
      ["a", { value: 3, text: "" }],
      ["comment", { value: -1, text: "fine" }],
    ],
  );
  assert.equal(givenAnswers(undefined).size, 0);
});

/** @typedef {import("../../questionnaire/pages.js").Kind} Kind */
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
