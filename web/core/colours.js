// The colours and the font that tokens.css defines as custom properties, read once per theme for drawing on a canvas.

const TOKENS = /** @type {const} */ ([
  "bg",
  "surface",
  "line",
  "ink",
  "ink-2",
  "blue",
  "blue-tint",
  "red",
  "red-tint",
  "item-small",
  "item-middle",
  "item-large",
  "item-edge",
  "wall",
  "goal",
  "goal-hatch",
  "goal-edge",
  "ok",
  "attention",
  "bad",
  "focus",
  "font",
]);

/** @typedef {Record<(typeof TOKENS)[number], string>} Theme */

/** @type {Theme | null} */
let cached = null;

/** The colours of the theme in use; a new object whenever the theme changes. @returns {Theme} */
export function currentTheme() {
  if (cached === null) {
    watchTheme();
    const style = getComputedStyle(document.documentElement);
    const pairs = TOKENS.map((token) => [token, style.getPropertyValue(`--${token}`).trim()]);
    cached = /** @type {Theme} */ (Object.fromEntries(pairs));
  }
  return cached;
}

let watching = false;

function watchTheme() {
  if (watching) return;
  watching = true;
  const forget = () => (cached = null);
  for (const query of ["(prefers-color-scheme: dark)", "(forced-colors: active)"]) {
    matchMedia(query).addEventListener("change", forget);
  }
  addEventListener("movingout-theme", forget); // theme.js: the reader chose another one
  addEventListener("load", forget); // a style sheet that came after the first drawing
}

/**
 * Whichever of two colours is easier to read on `background` (all "#rrggbb").
 * @param {string} background @param {string} one @param {string} other
 */
export function readable(background, one, other) {
  return contrast(background, one) >= contrast(background, other) ? one : other;
}

/** WCAG contrast ratio of two "#rrggbb" colours. @param {string} one @param {string} other */
export function contrast(one, other) {
  const [bright, dark] = [luminance(one), luminance(other)].sort((a, b) => b - a);
  return /** @type {number} */ (bright + 0.05) / /** @type {number} */ (dark + 0.05);
}

/** Relative luminance by WCAG 2. @param {string} colour */
function luminance(colour) {
  const [r, g, b] = [1, 3, 5].map((at) => {
    const channel = parseInt(colour.slice(at, at + 2), 16) / 255;
    return channel <= 0.04045 ? channel / 12.92 : ((channel + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * /** @type {number} */ (r) + 0.7152 * /** @type {number} */ (g) + 0.0722 * /** @type {number} */ (b);
}
