// @ts-check
/*
 * Words in a box of a given size, such as a button beside the arena: where text is set large, they shrink until all of
 * them can be read, at first without a break within a word.
 */

const STEP = 0.05;
const LEAST_WHOLE = 0.45; // of the size that the style sheet asks for: smaller, a word breaks rather
const LEAST = 0.4;

/** Keeps `--fit`, a factor of the font size in the style sheet, at what fits. @param {HTMLElement} box */
export function fitWords(box) {
  new ResizeObserver(() => {
    box.toggleAttribute("data-whole", true);
    const isWhole = shrinks(box, LEAST_WHOLE);
    box.toggleAttribute("data-whole", false); // letters that grow later may break
    if (!isWhole) shrinks(box, LEAST);
  }).observe(box);
}

/** Whether everything can be read. @param {HTMLElement} box @param {number} least */
function shrinks(box, least) {
  for (let fit = 1; fit >= least - STEP / 2; fit -= STEP) {
    box.style.setProperty("--fit", fit.toFixed(2));
    if (!isCut(box)) return true;
  }
  return false;
}

/** @param {HTMLElement} box */
function isCut(box) {
  return box.scrollHeight > box.clientHeight || box.scrollWidth > box.clientWidth;
}
