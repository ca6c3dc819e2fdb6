// @ts-check
/*
 * The arena as the place to draw: mouse, finger and pen drag, keys move what is selected.
 */

import { actionFor } from "../core/shortcuts.js";
import { ARENA_HALF } from "../messages.js";
import { say } from "../text/catalogue.js";
import { announce, placeText } from "./announcements.js";
import { partName } from "./faults.js";
import { STEP, TURN, movedBy, partsOf, pathOf } from "./parts.js";
import { added, gestureAt } from "./pointing.js";

/** @typedef {import("./history.js").Drawing} Drawing */
/** @typedef {import("./parts.js").Point} Point */
/** @typedef {import("./pointing.js").Settings} Settings */
/**
 * @typedef {object} Commands of the page
 * @property {(tool: Settings["tool"]) => void} use
 * @property {() => void} undo
 * @property {() => void} redo
 * @property {() => void} remove
 * @property {() => void} duplicate
 * @property {(by: number) => void} turn
 * @property {() => void} endTrial
 * @property {() => boolean} playing whether a trial is shown
 */

const NEAR_PX = 16; // a pointer counts as on a handle; fingers are broader
const NEAR_TOUCH_PX = 26;
const FINE = 0.01;
/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class Canvas {
  /**
   * @param {HTMLCanvasElement} canvas @param {Drawing} drawing @param {Settings} settings
   * @param {Commands} commands
   */
  constructor(canvas, drawing, settings, commands) {
    this.canvas = canvas;
    this.drawing = drawing;
    this.settings = settings;
    this.commands = commands;
    /** @type {import("./pointing.js").Gesture | null} */
    this.gesture = null;
    this.pointer = -1;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", () => this.#cancel());
    document.addEventListener("keydown", (event) => this.#shortcut(event));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {PointerEvent} event @returns {Point} */
  #place(event) {
    const box = this.canvas.getBoundingClientRect();
    const unit = box.width / (2 * ARENA_HALF);
    return { x: (event.clientX - box.left) / unit - ARENA_HALF, y: ARENA_HALF - (event.clientY - box.top) / unit };
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (this.pointer !== -1 || event.button !== 0) return; // a second finger changes nothing
    if (this.commands.playing()) {
      this.commands.endTrial();
      this.drawing.select(null);
    }
    const near = ((event.pointerType === "touch" ? NEAR_TOUCH_PX : NEAR_PX) * 2 * ARENA_HALF) / this.canvas.clientWidth;
    const at = this.#place(event);
    this.gesture = gestureAt(this.drawing.map, this.drawing.selected, at, this.settings, near);
    if (this.gesture === null) return this.drawing.select(null);
    this.pointer = event.pointerId;
    this.canvas.setPointerCapture(event.pointerId);
    this.#go(at);
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (event.pointerId === this.pointer) this.#go(this.#place(event));
  }

  /** @param {Point} to */
  #go(to) {
    if (this.gesture === null) return;
    const { map, selected } = this.gesture(to);
    this.drawing.selected = null;
    this.drawing.preview(map);
    this.drawing.select(selected);
  }

  /** @param {PointerEvent} event */
  #up(event) {
    if (event.pointerId !== this.pointer) return;
    this.#go(this.#place(event));
    this.#end();
    this.drawing.settle();
    if (this.settings.tool !== "select") this.commands.use("select");
    this.drawing.select(this.drawing.selected);
  }

  #cancel() {
    if (this.pointer === -1) return;
    this.#end();
    this.drawing.cancel();
  }

  #end() {
    this.pointer = -1;
    this.gesture = null;
  }

  /** Undo, redo and a copy, wherever the focus is but in a text. @param {KeyboardEvent} event */
  #shortcut(event) {
    const { target } = event;
    const typing = target instanceof HTMLInputElement && !["checkbox", "range"].includes(target.type);
    if (typing || target instanceof HTMLTextAreaElement || !(event.ctrlKey || event.metaKey) || event.altKey) return;
    const { commands } = this;
    const action = actionFor(
      { z: event.shiftKey ? commands.redo : commands.undo, y: commands.redo, d: commands.duplicate },
      event,
    );
    if (!action) return;
    event.preventDefault();
    action();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { drawing, commands } = this;
    const arrow = ARROWS[event.key];
    if (arrow && drawing.selected) {
      const step = event.shiftKey ? FINE : STEP;
      const moved = movedBy(drawing.map, drawing.selected, arrow[0] * step, arrow[1] * step);
      drawing.change(moved, `${pathOf(drawing.selected)} by keys`);
      announce(placeText(drawing.map, drawing.selected));
      return event.preventDefault();
    }
    /** @type {Record<string, () => void>} */
    const keys = {
      Enter: () => this.#add(),
      Delete: commands.remove,
      Backspace: commands.remove,
      Escape: () => this.#leave(),
      r: () => commands.turn(event.shiftKey ? -TURN : TURN),
      ",": () => this.#next(-1),
      ".": () => this.#next(1),
      s: () => this.#use("select"),
      w: () => this.#use("wall"),
      g: () => this.#use("goal"),
      i: () => this.#use("item"),
    };
    const action = actionFor(keys, event);
    if (!action) return;
    event.preventDefault();
    action();
  }

  /** @param {Settings["tool"]} tool */
  #use(tool) {
    announce(say(`editor.tool.${tool}`));
    this.commands.use(tool);
  }

  #leave() {
    this.#cancel();
    this.commands.use("select");
    this.drawing.select(null);
  }

  /** The part after the selected one, or before it. @param {1 | -1} by */
  #next(by) {
    const parts = partsOf(this.drawing.map);
    const { selected } = this.drawing;
    const now = selected ? parts.findIndex((part) => pathOf(part) === pathOf(selected)) : by === 1 ? -1 : 0;
    const part = parts[(now + by + parts.length) % parts.length];
    this.drawing.select(part);
    announce(`${partName(part)}. ${placeText(this.drawing.map, part)}`);
  }

  /** What the tool adds, in the middle of the arena. */
  #add() {
    if (this.settings.tool === "select") return;
    const { map, selected } = added(this.drawing.map, this.settings, { x: 0, y: 0 });
    this.drawing.change(map);
    this.commands.use("select");
    this.drawing.select(selected);
    if (selected) announce(say("editor.added", { part: partName(selected) }));
  }
}
