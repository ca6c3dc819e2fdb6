// @ts-check
/*
 * Whose the answers are that this browser keeps until they are sent. A person's token changes whenever they open their
 * link again; their answers follow them, and nobody else finds them.
 */

import { renameUnsent } from "../questionnaire/unsent_answers.js";

/** Under which their answers are kept until they are sent. @param {string} token */
export function unsentName(token) {
  return token.slice(0, 12);
}

/**
 * Somebody arrived: unsent answers of theirs are found under their new token, those of others stay only where these
 * may sit here. Whoever comes next at a shared machine finds none.
 * @param {readonly string[]} here tokens of everybody who sits here, the new one among them
 * @param {string} token the new one
 * @param {string | undefined} replaced the one that the same person had in this browser before
 * @param {readonly string[]} expected tokens of who may still come back beside them
 * @param {Pick<Storage, "getItem" | "setItem">} [storage]
 */
export function keepUnsentOf(here, token, replaced, expected, storage) {
  const names = new Map([...here, ...expected].map((one) => [unsentName(one), unsentName(one)]));
  if (replaced) names.set(unsentName(replaced), unsentName(token));
  renameUnsent((name) => names.get(name) ?? null, storage);
}

/**
 * Nobody sends them any more.
 * @param {readonly string[]} tokens whose they are
 * @param {Pick<Storage, "getItem" | "setItem">} [storage]
 */
export function dropUnsentOf(tokens, storage) {
  const gone = tokens.map(unsentName);
  renameUnsent((name) => (gone.includes(name) ? null : name), storage);
}
