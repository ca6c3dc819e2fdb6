// @ts-check
/*
 * Answers that have not reached the server yet, kept in localStorage, so that closing the tab while offline loses none.
 * Texts that the server does not take stay, too: nothing typed is lost, and nothing is sent twice in vain.
 */

import { lastingStorage } from "../core/browser_storage.js";

/** @typedef {import("./answer_queue.js").Answer} Answer */
/** @typedef {Answer & {refused?: boolean}} Kept */

const KEY = "movingout-study-unsent";

/** @param {Pick<Storage, "getItem">} storage @returns {Record<string, Kept>} */
function load(storage) {
  try {
    const kept = JSON.parse(storage.getItem(KEY) ?? "{}");
    return typeof kept === "object" && kept !== null ? kept : {};
  } catch {
    return {};
  }
}

/**
 * Says anew whose the kept answers are.
 * @param {(person: string) => string | null} nameNow from the name that they were kept under; null drops them
 * @param {Pick<Storage, "getItem" | "setItem">} [storage]
 */
export function renameUnsent(nameNow, storage = lastingStorage()) {
  const kept = Object.entries(load(storage));
  const now = kept.flatMap(([name, answer]) => {
    const [person, ...rest] = name.split(" ");
    const renamed = nameNow(person);
    return renamed === null ? [] : [{ name: [renamed, ...rest].join(" "), answer }];
  });
  const changed = now.length < kept.length || now.some(({ name }, at) => name !== kept[at][0]);
  if (changed) save(storage, Object.fromEntries(now.map(({ name, answer }) => [name, answer])));
}

/** @param {Pick<Storage, "setItem">} storage @param {Record<string, Kept>} kept */
function save(storage, kept) {
  try {
    storage.setItem(KEY, JSON.stringify(kept));
  } catch {
    // without storage they last as long as this page
  }
}

/** The unsent answers of one form of one participant. */
export class UnsentAnswers {
  /** @param {string} form participant, a space, and step @param {Pick<Storage, "getItem" | "setItem">} [storage] */
  constructor(form, storage = lastingStorage()) {
    this.prefix = `${form} `;
    this.storage = storage;
  }

  /** Those to be sent. @returns {Answer[]} */
  all() {
    return this.#kept().filter(({ refused }) => !refused);
  }

  /** Texts that were refused for good, as they were typed. @returns {Answer[]} */
  refused() {
    return this.#kept().filter(({ refused }) => refused);
  }

  #kept() {
    return Object.entries(load(this.storage))
      .filter(([name]) => name.startsWith(this.prefix))
      .map(([, answer]) => answer);
  }

  /** @param {Answer} answer */
  add(answer) {
    save(this.storage, { ...load(this.storage), [this.prefix + answer.question]: answer });
  }

  /** It has arrived, unless a newer one has come since. @param {Answer} answer */
  remove(answer) {
    this.#replace(answer, null);
  }

  /** The server will never take it: a text stays, to be changed; a choice is made anew. @param {Answer} answer */
  refuse(answer) {
    this.#replace(answer, answer.text ? { ...answer, refused: true } : null);
  }

  /** Leaves a newer answer as it is. @param {Answer} answer @param {Kept | null} other */
  #replace(answer, other) {
    const kept = load(this.storage);
    const name = this.prefix + answer.question;
    if (kept[name]?.value !== answer.value || kept[name].text !== answer.text) return;
    if (other) kept[name] = other;
    else delete kept[name];
    save(this.storage, kept);
  }
}
