// @ts-check
/*
 * Answers that have not reached the server yet, kept in localStorage, so that closing the tab while offline loses none.
 */

import { lastingStorage } from "../core/browser_storage.js";

/** @typedef {import("./answer_queue.js").Answer} Answer */

const KEY = "movingout-study-unsent";

/** @param {Pick<Storage, "getItem">} storage @returns {Record<string, Answer>} */
function load(storage) {
  try {
    const kept = JSON.parse(storage.getItem(KEY) ?? "{}");
    return typeof kept === "object" && kept !== null ? kept : {};
  } catch {
    return {};
  }
}

/** The unsent answers of one form of one participant. */
export class UnsentAnswers {
  /** @param {string} form names participant and step @param {Pick<Storage, "getItem" | "setItem">} [storage] */
  constructor(form, storage = lastingStorage()) {
    this.prefix = `${form} `;
    this.storage = storage;
  }

  /** @returns {Answer[]} */
  all() {
    return Object.entries(load(this.storage))
      .filter(([name]) => name.startsWith(this.prefix))
      .map(([, answer]) => answer);
  }

  /** @param {Answer} answer */
  add(answer) {
    this.#write({ ...load(this.storage), [this.prefix + answer.question]: answer });
  }

  /** It has arrived, unless a newer one has come since. @param {Answer} answer */
  remove(answer) {
    const kept = load(this.storage);
    const newest = kept[this.prefix + answer.question];
    if (newest?.value !== answer.value || newest.text !== answer.text) return;
    delete kept[this.prefix + answer.question];
    this.#write(kept);
  }

  /** @param {Record<string, Answer>} kept */
  #write(kept) {
    try {
      this.storage.setItem(KEY, JSON.stringify(kept));
    } catch {
      // without storage they last as long as this page
    }
  }
}
