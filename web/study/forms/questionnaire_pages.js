// @ts-check
/*
 * Which questions stand on which page, and what is missing. Pure.
 */

/** @typedef {"likert7" | "tlx" | "choice" | "text"} Kind */
/** @typedef {{id: string, kind: Kind, label: string, text: string, required?: boolean}} Item */
/**
 * An answer: a value of the scale, or -1 for "I prefer not to answer" and for a text.
 * @typedef {{value: number, text: string}} Given
 */

export const PER_PAGE = 3;

/**
 * Three questions per page, every text on one of its own.
 * @template {Item} T
 * @param {readonly T[]} items
 * @returns {T[][]}
 */
export function paginate(items) {
  /** @type {T[][]} */
  const pages = [];
  for (const item of items) {
    const page = pages.at(-1);
    const fits = page && page.length < PER_PAGE && page[0].kind !== "text" && item.kind !== "text";
    if (fits) page.push(item);
    else pages.push([item]);
  }
  return pages;
}

/**
 * The questions of a page that have no answer yet. "I prefer not to answer" is one; a text may stay empty unless it is
 * said to be required, and anything that is said not to be may be passed over.
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
 * Where to go on after a reload: the first page with something missing, else the last.
 * @param {readonly (readonly Item[])[]} pages
 * @param {ReadonlyMap<string, Given>} answers
 */
export function resumePage(pages, answers) {
  const first = pages.findIndex((page) => missing(page, answers).length > 0);
  return first === -1 ? pages.length - 1 : first;
}

/**
 * "Questions 4–6 of 10".
 * @param {readonly (readonly Item[])[]} pages
 * @param {number} page
 */
export function pageTitle(pages, page) {
  const before = pages.slice(0, page).flat().length;
  const count = pages[page].length;
  const total = pages.flat().length;
  return count === 1 ? `Question ${before + 1} of ${total}` : `Questions ${before + 1}–${before + count} of ${total}`;
}

/**
 * What the server kept for this seat.
 * @param {unknown} document the `answers` of GET /api/rooms/{room}/answers
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

/** @param {number} count */
export function missingSentence(count) {
  const what = count === 1 ? "One answer is" : `${count} answers are`;
  return `${what} missing on this page. Choose a number, or “I prefer not to answer”.`;
}
