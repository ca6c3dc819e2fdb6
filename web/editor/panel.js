// @ts-check
/*
 * The properties of the selected part as fields, and the list of all parts, by which the drawing can be changed
 * without a pointer.
 */

import { byId, el } from "../core/dom.js";
import { ARENA_HALF } from "../messages.js";
import { say } from "../text/catalogue.js";
import { partName } from "./faults.js";
import { SHAPES, SIZES, changed, isRect, movedTo, partsOf, pathOf, reshaped, resized, scaled } from "./parts.js";
import { sides, thing, turnedTo } from "./parts.js";

/** @typedef {import("./history.js").Drawing} Drawing */
/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */
/**
 * @typedef {object} NumberField
 * @property {string} name
 * @property {number} value
 * @property {number} least
 * @property {number} most
 * @property {number} step
 * @property {(value: number) => GameMap} apply
 */

const DEGREES = 180 / Math.PI;

export class Panel {
  /** @param {Drawing} drawing */
  constructor(drawing) {
    this.drawing = drawing;
    this.list = byId("parts", HTMLSelectElement);
    this.fields = byId("fields", HTMLElement);
    this.shown = ""; // which part the fields are of
    this.list.addEventListener("change", () => {
      const part = partsOf(drawing.map).find((each) => pathOf(each) === this.list.value) ?? null;
      drawing.select(part);
    });
  }

  refresh() {
    const { map, selected } = this.drawing;
    const options = partsOf(map).map((part) => [pathOf(part), this.#label(map, part)]);
    options.unshift(["", say("editor.nothing")]);
    this.list.replaceChildren(...options.map(([value, label]) => el("option", { value }, label)));
    this.list.value = selected ? pathOf(selected) : "";
    const key = selected ? pathOf(selected) : "";
    if (key !== this.shown) this.#build(selected);
    this.shown = key;
    if (selected) this.#fill(selected);
  }

  /** @param {GameMap} map @param {Part} part */
  #label(map, part) {
    const it = thing(map, part);
    if (!("shape" in it)) return partName(part);
    return `${partName(part)} (${say(`editor.shape.${it.shape}`)}, ${say(`editor.size.${it.size}`)})`;
  }

  /** @param {Part | null} part */
  #build(part) {
    if (part === null) return this.fields.replaceChildren();
    const numbers = this.#numbers(part).map(({ name, least, most, step }) =>
      el(
        "div",
        { class: "field" },
        el("label", { for: `field-${name}` }, say(`editor.field.${name}`)),
        el("input", { id: `field-${name}`, class: "input", type: "number", min: least, max: most, step }),
      ),
    );
    const choices =
      part.kind === "items" ? [this.#choice("shape", SHAPES), this.#choice("size", Object.keys(SIZES))] : [];
    this.fields.replaceChildren(...choices, ...numbers);
    for (const { name } of this.#numbers(part)) {
      const input = byId(`field-${name}`, HTMLInputElement);
      input.addEventListener("input", () => this.#typed(name, input.valueAsNumber));
      input.addEventListener("blur", () => this.refresh());
    }
  }

  /** @param {"shape" | "size"} name @param {readonly string[]} values */
  #choice(name, values) {
    const options = values.map((value) => el("option", { value }, say(`editor.${name}.${value}`)));
    const select = el("select", { id: `field-${name}`, class: "select" }, ...options);
    select.addEventListener("change", () => {
      const { map, selected } = this.drawing;
      if (!selected) return;
      const now =
        name === "size" ? resized(map, selected, select.value) : changed(map, selected, { shape: select.value });
      this.drawing.change(now);
    });
    return el("div", { class: "field" }, el("label", { for: `field-${name}` }, say(`editor.field.${name}`)), select);
  }

  /** @param {string} name @param {number} value */
  #typed(name, value) {
    const { selected } = this.drawing;
    const field = selected && this.#numbers(selected).find((each) => each.name === name);
    if (!selected || !field || !(value >= field.least && value <= field.most)) return; // still being typed
    this.drawing.change(field.apply(value), `${pathOf(selected)}.${name}`);
  }

  /** @param {Part} part */
  #fill(part) {
    for (const { name, value } of this.#numbers(part)) {
      const input = byId(`field-${name}`, HTMLInputElement);
      if (document.activeElement !== input) input.value = String(Math.round(value * 1000) / 1000);
    }
    const it = thing(this.drawing.map, part);
    if (!("shape" in it)) return;
    byId("field-shape", HTMLSelectElement).value = it.shape;
    byId("field-size", HTMLSelectElement).value = it.size;
  }

  /** @param {Part} part @returns {NumberField[]} */
  #numbers(part) {
    const { map } = this.drawing;
    const it = thing(map, part);
    const place = { least: -ARENA_HALF, most: ARENA_HALF, step: 0.01 };
    if ("x0" in it && isRect(part)) {
      const { left, bottom, right, top } = sides(it);
      const side = { least: 0.02, most: 2 * ARENA_HALF, step: 0.01 };
      const shaped = (/** @type {number} */ width, /** @type {number} */ height) =>
        reshaped(map, part, { x: left, y: bottom }, { x: left + width, y: bottom + height });
      const moved = (/** @type {number} */ x, /** @type {number} */ y) =>
        movedTo(map, part, { x: x + (right - left) / 2, y: y + (top - bottom) / 2 });
      return [
        { name: "left", value: left, ...place, apply: (x) => moved(x, bottom) },
        { name: "bottom", value: bottom, ...place, apply: (y) => moved(left, y) },
        { name: "width", value: right - left, ...side, apply: (width) => shaped(width, top - bottom) },
        { name: "height", value: top - bottom, ...side, apply: (height) => shaped(right - left, height) },
      ];
    }
    const body = /** @type {import("./parts.js").Pose} */ (it);
    const turned = (/** @type {number} */ degrees) => turnedTo(map, part, degrees / DEGREES);
    /** @type {NumberField[]} */
    const fields = [
      { name: "x", value: body.x, ...place, apply: (x) => movedTo(map, part, { x, y: body.y }) },
      { name: "y", value: body.y, ...place, apply: (y) => movedTo(map, part, { x: body.x, y }) },
      { name: "angle", value: body.angle * DEGREES, least: -360, most: 360, step: 5, apply: turned },
    ];
    if (!("shape" in it)) return fields;
    const radius = {
      least: 0.03,
      most: 0.4,
      step: 0.01,
      apply: (/** @type {number} */ value) => scaled(map, part, value),
    };
    const mass = (/** @type {number} */ value) => changed(map, part, { mass: value });
    return [
      ...fields,
      { name: "scale", value: it.scale, ...radius },
      { name: "mass", value: it.mass, least: 0.01, most: 100, step: 0.01, apply: mass },
    ];
  }
}
