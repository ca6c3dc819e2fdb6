// @ts-check
/*
 * Which gamepad drove whom last, for as long as the tab is there: two people at one screen keep theirs over a reload,
 * and over the rounds of a study, in which they change robots.
 */

/** @typedef {import("./seats.js").PadName} PadName */

export class PadMemory {
  #key;
  #people;
  #storage;
  /** @type {(PadName | null | undefined)[]} by person */
  #pads = [];

  /**
   * @param {string} scope  what the pads are remembered for
   * @param {readonly number[]} [people]  who sits in the blue seat and who in the red
   * @param {() => Pick<Storage, "getItem" | "setItem">} [storage]
   */
  constructor(scope, people = [0, 1], storage = () => sessionStorage) {
    this.#key = keyOf(scope);
    this.#people = people;
    this.#storage = storage;
    try {
      const kept = JSON.parse(storage().getItem(this.#key) ?? "[]");
      if (Array.isArray(kept)) this.#pads = kept;
    } catch {
      // Without storage the pads are known until the page is left.
    }
  }

  /** @param {number} seat @returns {PadName | undefined} */
  get(seat) {
    return this.#pads[this.#people[seat]] ?? undefined;
  }

  /** @param {number} seat @param {PadName | undefined} pad */
  set(seat, pad) {
    this.#pads[this.#people[seat]] = pad;
    try {
      this.#storage().setItem(this.#key, JSON.stringify(this.#pads));
    } catch {
      // As above.
    }
  }
}

/** @param {string} scope @param {Pick<Storage, "removeItem">} storage */
export function forgetPads(scope, storage) {
  storage.removeItem(keyOf(scope));
}

/** @param {string} scope */
function keyOf(scope) {
  return `movingout.pads.${scope}`;
}

export const STUDY_PADS = "study"; // the scope of a study: from "Try your controls" to the last round
