// @ts-check
/*
 * Which questions stand on which page, and what is missing. Pure.
 */

/** @typedef {import("../messages.js").QuestionKind} Kind */
/**
 * A question, as study/questionnaire.py sends it.
 * @typedef {object} Item
 * @property {string} id
 * @property {Kind} kind
 * @property {string} label short name, for tables
 * @property {string} text what the participant reads
 * @property {string[]} [options] of a choice
 * @property {[string, string]} [ends] what the two ends of a scale mean
 * @property {boolean} [required]
 */
/**
 * An answer: a value of the scale, or -1 for "I prefer not to answer" and for a text. A text that was written on
 * another device is `hidden`.
 * @typedef {{value: number, text: string, hidden?: boolean}} Given
 */

export const PER_PAGE = 3;

/**
 * At most three questions per page, spread evenly (10 make 3, 3, 2, 2); every text on a page of its own.
 * @template {Item} T
 * @param {readonly T[]} items
 * @returns {T[][]}
 */
export function paginate(items) {
  /** @type {T[][]} */
  const pages = [];
  /** @type {T[]} */
  let scales = [];
  const flush = () => {
    pages.push(...spread(scales));
    scales = [];
  };
  for (const item of items) {
    if (item.kind !== "text") {
      scales.push(item);
      continue;
    }
    flush();
    pages.push([item]);
  }
  flush();
  return pages;
}

/**
 * Pages whose sizes differ by one at most, the larger ones first.
 * @template T
 * @param {readonly T[]} items
 * @returns {T[][]}
 */
function spread(items) {
  const count = Math.ceil(items.length / PER_PAGE);
  const larger = items.length % count;
  const size = Math.floor(items.length / count);
  return Array.from({ length: count }, (_, page) => {
    const start = page * size + Math.min(page, larger);
    return items.slice(start, start + size + Number(page < larger));
  });
}

/**
 * The questions of a page that have no answer yet. "I prefer not to answer" is an answer; a text may stay empty unless
 * it is required, and a scale may if it is marked as not required.
 * @template {Item} T
 * @param {readonly T[]} page
 * @param {ReadonlyMap<string, Given>} answers
 */
export function missing(page, answers) {
  return page.filter((item) => {
    if (item.kind === "text") return item.required === true && !answers.get(item.id)?.text.trim();
    return item.required !== false && !answers.has(item.id);
  });
}

/**
 * Where to continue after a reload: the first page with something missing, but none further than the page that has the
 * last answer or, where nothing there is open or is still being written, the one after it.
 * @param {readonly (readonly Item[])[]} pages
 * @param {ReadonlyMap<string, Given>} answers
 */
export function resumePage(pages, answers) {
  const latest = pages.map((page) => page.some(({ id }) => answers.has(id))).lastIndexOf(true);
  const isOpen = pages[latest]?.some(({ id, kind }) => kind === "text" || !answers.has(id));
  const reached = Math.min(isOpen ? latest : latest + 1, pages.length - 1);
  const first = pages.findIndex((page) => missing(page, answers).length > 0);
  return first === -1 ? reached : Math.min(first, reached);
}

/**
 * Where a page stands in the whole questionnaire: questions 4 to 6 of 10, which are 3.
 * @param {readonly (readonly Item[])[]} pages
 * @param {number} page
 */
export function positionOf(pages, page) {
  const before = pages.slice(0, page).flat().length;
  const count = pages[page].length;
  return { first: before + 1, last: before + count, total: pages.flat().length, count };
}

/**
 * Answers the server has kept; entries of another shape are left out.
 * @param {unknown} document by question id
 * @returns {Map<string, Given>}
 */
export function givenAnswers(document) {
  const answers = new Map();
  for (const [question, answer] of Object.entries(document ?? {})) {
    if (typeof answer?.value === "number")
      answers.set(question, { value: answer.value, text: String(answer.text ?? "") });
  }
  return answers;
}
