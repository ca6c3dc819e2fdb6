// @ts-check
/*
 * Words in a box of a given size, such as a button beside the arena: where text is set large, they shrink until all of
 * them can be read.
 */

const STEP = 0.05;
const LEAST = 0.4; // of the size that the style sheet asks for

/** Keeps `--fit`, a factor of the font size in the style sheet, at what fits. @param {HTMLElement} box */
export function fitWords(box) {
  new ResizeObserver(() => {
    for (let fit = 1; fit >= LEAST; fit -= STEP) {
      box.style.setProperty("--fit", fit.toFixed(2));
      if (!isCut(box)) return;
    }
  }).observe(box);
}

/** @param {HTMLElement} box */
function isCut(box) {
  return box.scrollHeight > box.clientHeight || box.scrollWidth > box.clientWidth;
}
