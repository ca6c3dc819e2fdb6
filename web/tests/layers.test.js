// @ts-check
// The order of the folders: a module imports from its own folder and from layers before its own, never in a circle.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, normalize } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const WEB = fileURLToPath(new URL("../", import.meta.url));
const LAYERS = [
  ["."], // messages.js (generated), shapes.js, theme.js
  ["core"],
  ["text"],
  ["components", "input", "view", "wire"],
  ["questionnaire"],
  ["study"],
  ["play"], // shows the frame of a study around a round, so it lies above the study
  ["replay"],
  ["admin", "annotate", "editor", "experimenter", "lobby"],
];

/** @returns {Map<string, string[]>} each module with the modules it imports, as paths below web/ */
function imports() {
  const names = readdirSync(WEB, { recursive: true, encoding: "utf-8" });
  const modules = names.filter((name) => name.endsWith(".js") && !name.startsWith("tests"));
  return new Map(
    modules.map((name) => {
      const source = readFileSync(join(WEB, name), "utf-8");
      const found = [...source.matchAll(/^(?:import|export)[^;]*?from "(\.[^"]+)"/gm)];
      return [name, found.map(([, path]) => normalize(join(dirname(name), path)))];
    }),
  );
}

/** @param {string} module */
const folder = (module) => (module.includes("/") ? module.split("/")[0] : ".");
/** @param {string} module */
const layer = (module) => LAYERS.findIndex((folders) => folders.includes(folder(module)));

test("every folder has a layer", () => {
  assert.deepEqual(
    [...imports().keys()].filter((module) => layer(module) === -1),
    [],
  );
});

test("no module imports from a layer above its own, or from another folder of its layer", () => {
  const wrong = [...imports()].flatMap(([module, targets]) =>
    targets
      .filter((target) => folder(target) !== folder(module) && layer(target) >= layer(module))
      .map((target) => `${module} imports ${target}`),
  );
  assert.deepEqual(wrong, []);
});

test("no module imports itself, however far around", () => {
  const graph = imports();
  /** @param {string} module @param {string[]} path @returns {string[] | null} */
  const circle = (module, path) => {
    if (path.includes(module)) return [...path.slice(path.indexOf(module)), module];
    for (const target of graph.get(module) ?? []) {
      const found = circle(target, [...path, module]);
      if (found) return found;
    }
    return null;
  };
  assert.deepEqual(
    [...graph.keys()].map((module) => circle(module, [])).filter((found) => found !== null),
    [],
  );
});
