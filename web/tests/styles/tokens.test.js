// @ts-check
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { contrast, readable } from "../../core/colours.js";

const CSS = readFileSync(new URL("../../styles/tokens.css", import.meta.url), "utf-8");

/** The custom properties of the rule with this selector. @param {string} selector */
function tokens(selector) {
  const rule = CSS.slice(CSS.indexOf(`${selector} {`)).split("}")[0];
  return new Map([...rule.matchAll(/(--[\w-]+):\s*([^;]+);/g)].map(([, name, value]) => [name, value]));
}

const LIGHT = tokens(":root");
const DARK = tokens(':root[data-theme="dark"]');

test("the dark theme is the same whether the system or the reader asks for it", () => {
  assert.deepEqual(tokens(':root:not([data-theme="light"])'), DARK);
});

test("the dark theme changes every colour and nothing else", () => {
  const colours = [...LIGHT].filter(([, value]) => value.startsWith("#")).map(([name]) => name);
  assert.deepEqual([...DARK.keys()], colours);
});

for (const [theme, values] of Object.entries({ light: LIGHT, dark: DARK })) {
  /** @param {string} name */
  const colour = (name) => values.get(`--${name}`) ?? "";

  test(`text reaches 4.5:1 in the ${theme} theme`, () => {
    const pairs = [
      ["ink", "bg"],
      ["ink", "surface"],
      ["ink", "track"],
      ["ink-2", "bg"],
      ["ink-2", "surface"],
      ["on-ink", "ink"],
      ["ok-ink", "ok-tint"],
      ["attention-ink", "attention-tint"],
      ["bad-ink", "bad-tint"],
      ["bad-ink", "surface"],
    ];
    for (const [text, ground] of pairs)
      assert.ok(contrast(colour(text), colour(ground)) >= 4.5, `${text} on ${ground}`);
  });

  test(`items, outlines, robots and their rings reach 3:1 on floor and goal in the ${theme} theme`, () => {
    const drawn = ["item-edge", "blue", "red", "goal-edge", "attention", "wall"];
    const fills = ["item-small", "item-middle", "item-large"]; // each has the edge around it
    for (const mark of [...drawn, ...fills]) {
      for (const ground of ["surface", "goal", ...(fills.includes(mark) ? [] : ["goal-hatch"])])
        assert.ok(contrast(colour(mark), colour(ground)) >= 3, `${mark} on ${ground}`);
    }
  });

  test(`the marks on items reach 4.5:1 in the ${theme} theme`, () => {
    for (const size of ["middle", "large"]) {
      const ground = colour(`item-${size}`);
      assert.ok(contrast(readable(ground, "#ffffff", "#18212c"), ground) >= 4.5, size);
    }
  });

  test(`a larger item is darker in the ${theme} theme`, () => {
    const greys = ["small", "middle", "large"].map((size) => contrast(colour(`item-${size}`), "#000000"));
    assert.deepEqual(
      [...greys].sort((a, b) => b - a),
      greys,
    );
  });

  test(`marks and edges reach 3:1 in the ${theme} theme`, () => {
    const pairs = [
      ["blue", "surface"],
      ["red", "surface"],
      ["on-blue", "blue"],
      ["on-red", "red"],
      ["control-line", "surface"],
      ["goal-edge", "goal"],
      ["focus", "bg"],
      ["focus", "surface"],
      ["wall", "surface"],
      ["bad", "surface"],
    ];
    for (const [mark, ground] of pairs) assert.ok(contrast(colour(mark), colour(ground)) >= 3, `${mark} on ${ground}`);
  });
}
