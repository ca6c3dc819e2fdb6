// Drawing in arena units on a canvas of any size.

import { ARENA_HALF } from "../messages.js";

const LEAST_LETTERS_PX = 12; // CSS pixels

/** @typedef {import("../core/colours.js").Theme} Theme */
/** @typedef {import("./render.js").Triple} Triple */

/** A 2D context in arena units, y up. */
export class ArenaContext {
  /**
   * @param {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D} ctx
   * @param {Theme} theme
   * @param {number} side canvas side in pixels
   * @param {number} [density] pixels of the canvas per CSS pixel
   */
  constructor(ctx, theme, side, density = 1) {
    this.ctx = ctx;
    this.theme = theme;
    this.density = density;
    this.unit = side / (2 * ARENA_HALF); // pixels per arena unit
    this.hair = Math.max(side / 640, 0.75 * density); // the thinnest line, pixels
  }

  /** @param {number} x @param {number} y @returns {[number, number]} */
  at(x, y) {
    return [(x + ARENA_HALF) * this.unit, (ARENA_HALF - y) * this.unit];
  }

  /**
   * Calls `draw` with the origin at a pose, turned with it; pixels, y down.
   * @param {Triple} pose
   * @param {() => void} draw
   */
  around([x, y, angle], draw) {
    this.ctx.save();
    this.ctx.translate(...this.at(x, y));
    this.ctx.rotate(-angle);
    draw();
    this.ctx.restore();
  }

  /** @param {number} radius pixels */
  circle(radius) {
    this.ctx.beginPath();
    this.ctx.arc(0, 0, radius, 0, 2 * Math.PI);
  }

  /** Letters on a body, never too small to read. @param {number} size arena units @returns {number} pixels */
  letters(size) {
    return Math.max(size * this.unit, LEAST_LETTERS_PX * this.density);
  }

  /** @param {string} text @param {number} size pixels @param {string} colour */
  label(text, size, colour) {
    this.ctx.font = `700 ${size}px ${this.theme.font || "sans-serif"}`;
    this.ctx.textAlign = "center";
    this.ctx.textBaseline = "middle";
    this.ctx.fillStyle = colour;
    this.ctx.fillText(text, 0, size * 0.06);
  }
}
