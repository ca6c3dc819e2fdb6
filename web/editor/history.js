// @ts-check
/*
 * The drawing over time: the map, what is selected, undo and redo, and what of it a browser keeps.
 */

import { exists } from "./parts.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */

const MOST_STEPS = 200;

export class Drawing {
  /** @param {GameMap} map @param {() => void} [onChange] */
  constructor(map, onChange = () => {}) {
    this.map = map;
    /** @type {Part | null} */
    this.selected = null;
    this.onChange = onChange;
    /** @type {GameMap[]} */
    this.past = [];
    /** @type {GameMap[]} */
    this.future = [];
    /** @type {GameMap | null} the map before a change that is still under the pointer */
    this.before = null;
    this.lastField = "";
  }

  /**
   * One step that can be undone. Steps in the same `field`, such as letters of a title, are one.
   * @param {GameMap} map @param {string} [field]
   */
  change(map, field = "") {
    if (map === this.map) return;
    if (field === "" || field !== this.lastField) this.#keep(this.map);
    this.lastField = field;
    this.#set(map);
  }

  /**
   * The map as it was drawn in another tab, be it in many steps, is one step here.
   * @param {GameMap | null} map
   * @returns {boolean} whether it was taken: not where it is the same, or where a part is being dragged here
   */
  adopt(map) {
    if (map === null || this.before !== null || JSON.stringify(map) === JSON.stringify(this.map)) return false;
    this.selected = null;
    this.change(map, "another tab");
    return true;
  }

  /** A change that goes on, as while dragging; `settle` makes it one step. @param {GameMap} map */
  preview(map) {
    this.before ??= this.map;
    this.#set(map);
  }

  settle() {
    if (this.before !== null && this.before !== this.map) this.#keep(this.before);
    this.before = null;
    this.lastField = "";
  }

  /** Back to where a drag began. */
  cancel() {
    if (this.before !== null) this.#set(this.before);
    this.before = null;
  }

  /** @returns {boolean} whether there was a step to undo */
  undo() {
    const map = this.past.pop();
    if (map === undefined) return false;
    this.future.push(this.map);
    this.lastField = "";
    this.#set(map);
    return true;
  }

  /** @returns {boolean} whether there was a step to redo */
  redo() {
    const map = this.future.pop();
    if (map === undefined) return false;
    this.past.push(this.map);
    this.lastField = "";
    this.#set(map);
    return true;
  }

  /** @param {Part | null} part */
  select(part) {
    this.selected = part;
    this.lastField = "";
    this.onChange();
  }

  /** @param {GameMap} map */
  #keep(map) {
    this.past.push(map);
    if (this.past.length > MOST_STEPS) this.past.shift();
    this.future = [];
  }

  /** @param {GameMap} map */
  #set(map) {
    this.map = map;
    if (this.selected && !exists(map, this.selected)) this.selected = null;
    this.onChange();
  }
}

/**
 * What was kept, when it still looks like a map; null for anything else.
 * @param {string | null} text
 * @returns {GameMap | null}
 */
export function keptMap(text) {
  try {
    const map = JSON.parse(text ?? "");
    const rects = [...map.walls, ...map.goals].every(({ x0, y0, x1, y1 }) => [x0, y0, x1, y1].every(Number.isFinite));
    const bodies = [map.robots.blue, map.robots.red, ...map.items];
    const poses = bodies.every(({ x, y, angle }) => [x, y, angle].every(Number.isFinite));
    const items = map.items.every((/** @type {any} */ item) => typeof item.shape === "string" && item.scale > 0);
    return rects && poses && items && typeof map.title === "string" ? map : null;
  } catch {
    return null;
  }
}
