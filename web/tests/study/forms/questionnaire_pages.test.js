// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import {
  givenAnswers,
  missing,
  missingSentence,
  pageTitle,
  paginate,
  resumePage,
} from "../../../study/forms/questionnaire_pages.js";

/** @type {import("../../../study/forms/questionnaire_pages.js").Item[]} */
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

test("the title counts questions over the whole questionnaire", () => {
  assert.deepEqual(
    [0, 1, 3].map((page) => pageTitle(PAGES, page)),
    ["Questions 1–3 of 10", "Questions 4–6 of 10", "Question 10 of 10"],
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

test("the summary says how many answers are missing", () => {
  assert.match(missingSentence(1), /^One answer is missing/);
  assert.match(missingSentence(2), /^2 answers are missing/);
});
