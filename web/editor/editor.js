// @ts-check
/*
 * The map editor: the drawing under a pointer or the keyboard, its checks, its trial by two computer players, its file.
 */

import { ApiError, requestJson } from "../core/api.js";
import { byId, el, notice } from "../core/dom.js";
import { save } from "../replay/source.js";
import { say, sayError, unmarked } from "../text/catalogue.js";
import { mapDescription, mapTitle } from "../text/names.js";
import { prepareTexts } from "../text/page.js";
import { fitCanvas } from "../view/render.js";
import { openRoom } from "../wire/open_room.js";
import { keepDrawnIn } from "../wire/played_map.js";
import { announce, turnText } from "./announcements.js";
import { Canvas } from "./canvas.js";
import { Checks, askServer } from "./checks.js";
import { faultText, faultyParts, partName } from "./faults.js";
import { Drawing } from "./history.js";
import { MAP, keep, keepHere, keptHere, keptLast } from "./memory.js";
import { drawEditor, drawMoment } from "./overlay.js";
import { Panel } from "./panel.js";
import { MOST, SHAPES, SIZES, duplicated, emptyMap, nameOf, removed, turnedTo, thing, TURN } from "./parts.js";
import { Trial, solutionText } from "./trial.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./pointing.js").Settings} Settings */

const MOST_BYTES = 64 * 1024;
const TOOLS = /** @type {const} */ (["select", "wall", "goal", "item"]);
/** What each tool draws. @type {Partial<Record<Settings["tool"], "walls" | "goals" | "items">>} */
const KINDS = { wall: "walls", goal: "goals", item: "items" };

/** @type {Settings} */
const settings = { tool: "select", shape: "star", size: "small", snap: true };
/** @type {Trial | null} */
let trial = null;
/** @type {GameMap | null} */
let checked = null; // the map that was last sent to be checked
let which = ""; // tabs with the same one draw the same map
let drawnHere = false; // it differs from what was kept, and from what another tab has drawn
/** @type {GameMap[]} */
let starts = [];

const arena = byId("arena", HTMLCanvasElement);
const titleField = byId("title", HTMLInputElement);
const aboutField = byId("about", HTMLTextAreaElement);
const message = byId("message", HTMLElement);
const startSelect = byId("start", HTMLSelectElement);

/** Brings the page up to date with the drawing. */
function refresh() {
  const { map, selected } = drawing;
  if (map !== checked) changed(map);
  panel.refresh();
  draw();
  byId("undo", HTMLButtonElement).disabled = drawing.past.length === 0;
  byId("redo", HTMLButtonElement).disabled = drawing.future.length === 0;
  const movable = selected !== null && selected.kind !== "robots";
  byId("delete", HTMLButtonElement).disabled = !movable;
  byId("duplicate", HTMLButtonElement).disabled = selected === null || duplicated(map, selected) === map;
  byId("turn", HTMLButtonElement).disabled = selected === null;
  for (const tool of TOOLS)
    byId(`tool-${tool}`, HTMLElement).setAttribute("aria-pressed", String(settings.tool === tool));
  byId("item-choice", HTMLElement).hidden = settings.tool !== "item";
  if (document.activeElement !== titleField) titleField.value = map.title;
  if (document.activeElement !== aboutField) aboutField.value = map.description;
}

/** The map is another one. @param {GameMap} map */
function changed(map) {
  checked = map;
  checks.begin(map);
  endTrial();
  message.replaceChildren();
  setButtons();
  (drawnHere ? keep : keepHere)(which, map);
}

/** Goes on with what another tab has drawn of this map, and keeps it: the next change here would overwrite it. */
function adopt() {
  const last = keptLast();
  if (last.which !== which) return;
  drawnHere = false;
  const adopted = drawing.adopt(last.map);
  drawnHere = true;
  if (!adopted) return;
  titleField.value = drawing.map.title; // also of a field that has the keyboard
  aboutField.value = drawing.map.description;
  message.replaceChildren(notice("", say("editor.adopted")));
}

function setButtons() {
  for (const id of ["solve", "play"]) byId(id, HTMLButtonElement).disabled = !checks.sound;
}

function draw() {
  fitCanvas(arena);
  if (trial) return trial.redraw();
  const faulty = checks.known ? faultyParts(checks.faults) : [];
  drawEditor(arena, drawing.map, { selected: drawing.selected, faulty, grid: settings.snap });
}

function endTrial() {
  trial?.close();
  trial = null;
}

/** @param {string} kind @param {...(Node | string)} parts */
function tell(kind, ...parts) {
  message.replaceChildren(notice(kind, ...parts));
  bringToSight(message); // a phone shows only a part of the page, and what was pressed may be far away
}

/** @param {HTMLElement} part */
function bringToSight(part) {
  part.scrollIntoView({ block: "nearest" });
}

/** Runs what asks the server, with its button off meanwhile. @param {string} id @param {() => Promise<void>} work */
async function asking(id, work) {
  const button = byId(id, HTMLButtonElement);
  const focused = document.activeElement === button;
  button.disabled = true;
  try {
    await work();
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    tell("bad", sayError(error));
  } finally {
    button.disabled = false;
    setButtons();
    if (focused && document.activeElement === document.body) button.focus({ preventScroll: true });
  }
}

async function solve() {
  const { map } = drawing;
  tell("", say("editor.solving"));
  const solution = await requestJson("/api/editor/solve", { body: { map } });
  if (drawing.map !== map) return; // it was changed meanwhile
  tell(solution.solved ? "ok" : "attention", solutionText(solution));
  drawing.select(null);
  const close = () => {
    endTrial();
    draw();
    arena.focus();
  };
  trial = new Trial(solution, (view) => drawMoment(arena, map, view), close);
  bringToSight(arena);
}

async function play() {
  const seats = [{ kind: "here" }, { kind: "partner" }];
  const room = await openRoom({ maps: [], map: drawing.map, seats });
  keepDrawnIn(room.room);
  location.assign(room.join_path);
}

function download() {
  const text = JSON.stringify(drawing.map, null, 2);
  save(new Blob([`${text}\n`], { type: "application/json" }), `${drawing.map.name}.json`);
}

/**
 * Another map takes the place of the drawing, unless it cannot be read; undo brings the drawing back.
 * @param {File} file
 */
async function open(file) {
  if (file.size > MOST_BYTES) return tell("bad", say("editor.open.large"));
  let document;
  try {
    document = JSON.parse(await file.text());
  } catch {
    return tell("bad", say("editor.open.noJson"));
  }
  try {
    const { map, faults } = await askServer(document);
    if (map) return replace(map);
    const sentences = faults.slice(0, 5).map((fault) => el("li", {}, faultText(fault)));
    tell("bad", say("editor.open.noMap"), el("ul", { class: "editor-faults" }, ...sentences));
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    tell("bad", sayError(error));
  }
}

/** @param {GameMap} map */
function replace(map) {
  drawing.selected = null;
  which = `${Date.now()}-${Math.random()}`;
  drawing.change(map);
  bringToSight(arena);
}

function startFrom() {
  const from = starts.find(({ name }) => name === startSelect.value);
  const title = from ? unmarked(say("editor.copy", { title: mapTitle(from) })) : say("editor.untitled");
  startSelect.value = "";
  if (from === undefined) return replace(emptyMap(title));
  const description = unmarked(mapDescription(from));
  replace({ ...from, title, description, name: nameOf(title), number: 0, mode: "practice" });
}

/** @param {Settings["tool"]} tool */
function use(tool) {
  const kind = KINDS[tool];
  const full = kind !== undefined && drawing.map[kind].length >= MOST[kind];
  settings.tool = full ? "select" : tool;
  endTrial();
  refresh();
  if (full) tell("attention", say(`editor.full.${kind}`, { count: MOST[kind] }));
}

function remove() {
  const { map, selected } = drawing;
  if (!selected || selected.kind === "robots") return;
  drawing.change(removed(map, selected));
  drawing.select(null);
  announce(say("editor.removed", { part: partName(selected) }));
}

function duplicate() {
  const { map, selected } = drawing;
  if (!selected) return;
  const more = duplicated(map, selected);
  if (more === map || selected.kind === "robots") return;
  drawing.change(more);
  const copy = { ...selected, index: more[selected.kind].length - 1 };
  drawing.select(copy);
  announce(say("editor.added", { part: partName(copy) }));
}

/** @param {number} by */
function turn(by) {
  const { map, selected } = drawing;
  if (!selected) return;
  const it = thing(map, selected);
  drawing.change(turnedTo(map, selected, "angle" in it ? it.angle + by : by));
  announce(turnText(drawing.map, selected));
}

function undo() {
  if (drawing.undo()) announce(say("editor.undone"));
}

function redo() {
  if (drawing.redo()) announce(say("editor.redone"));
}

function listen() {
  /** @type {Record<string, () => void>} */
  const clicks = {
    undo,
    redo,
    delete: remove,
    duplicate,
    turn: () => turn(TURN),
    solve: () => void asking("solve", solve),
    play: () => void asking("play", play),
    download,
    open: () => byId("file", HTMLInputElement).click(),
  };
  for (const [id, work] of Object.entries(clicks)) byId(id, HTMLButtonElement).addEventListener("click", work);
  for (const tool of TOOLS) byId(`tool-${tool}`, HTMLButtonElement).addEventListener("click", () => use(tool));
  startSelect.addEventListener("change", startFrom);
  titleField.addEventListener("input", () => {
    const title = titleField.value;
    drawing.change({ ...drawing.map, title, name: nameOf(title), number: 0 }, "title"); // no longer one of the paper's
  });
  aboutField.addEventListener("input", () =>
    drawing.change({ ...drawing.map, description: aboutField.value }, "about"),
  );
  const snap = byId("snap", HTMLInputElement);
  snap.addEventListener("change", () => {
    settings.snap = snap.checked;
    draw();
  });
  window.addEventListener("storage", ({ key }) => key === MAP && adopt());
  window.addEventListener("pageshow", ({ persisted }) => persisted && adopt());
  listenForFiles();
  listenForItem();
  new ResizeObserver(draw).observe(arena);
  window.addEventListener("movingout-theme", draw);
}

function listenForFiles() {
  const input = byId("file", HTMLInputElement);
  input.addEventListener("change", () => {
    const file = input.files?.[0];
    if (file) void open(file);
    input.value = "";
  });
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    if (file) void open(file);
  });
}

function listenForItem() {
  for (const [name, values] of /** @type {const} */ ([
    ["shape", SHAPES],
    ["size", Object.keys(SIZES)],
  ])) {
    const select = byId(`new-${name}`, HTMLSelectElement);
    select.replaceChildren(...values.map((value) => el("option", { value }, say(`editor.${name}.${value}`))));
    select.value = settings[name];
    select.addEventListener("change", () => (settings[name] = select.value));
  }
}

/** What there is to begin with. */
async function loadOffers() {
  const maps = await requestJson("/api/maps");
  starts = [...(maps.own ?? []), ...maps.maps, maps.practice];
  const options = starts.map((map) => el("option", { value: map.name }, mapTitle(map)));
  const blank = el("option", { value: "-" }, say("editor.start.empty"));
  startSelect.replaceChildren(el("option", { value: "" }, say("editor.start.choose")), blank, ...options);
}

await prepareTexts();
const begun = keptHere();
which = begun.which;
const drawing = new Drawing(begun.map ?? emptyMap(say("editor.untitled")));
const panel = new Panel(drawing);
const checks = new Checks(
  (part) => {
    drawing.select(part);
    arena.focus();
  },
  () => {
    setButtons();
    draw();
  },
);
drawing.onChange = refresh;
new Canvas(arena, drawing, settings, {
  use,
  undo,
  redo,
  remove,
  duplicate,
  turn,
  endTrial,
  playing: () => trial !== null,
});
listen();
refresh();
drawnHere = true;
loadOffers().catch((error) => tell("bad", sayError(error)));
Object.assign(window, { __editor: { drawing, checks: () => checks, trial: () => trial } });
