// @ts-check
/*
 * Words in a box of a given size, such as a button beside the arena: where text is set large, they shrink until all of
 * them can be read, at first without a break within a word.
 */

const STEP = 0.05;
const LEAST_WHOLE = 0.45; // of the size that the style sheet asks for: smaller, a word breaks rather
const LEAST = 0.4;

/**
 * Keeps `--fit`, a factor of the font size in the style sheet, at what fits. The box may be of any size that does not
 * depend on its words.
 * @param {HTMLElement} box
 * @param {readonly HTMLElement[]} [parts]  what may be cut within it
 * @returns {() => void}  to be called after the words have changed
 */
export function fitWords(box, parts = [box]) {
  const fit = () => {
    box.toggleAttribute("data-whole", true);
    const isWhole = shrinks(box, parts, LEAST_WHOLE);
    box.toggleAttribute("data-whole", false); // letters that grow later may break
    if (!isWhole) shrinks(box, parts, LEAST);
  };
  new ResizeObserver(fit).observe(box);
  return fit;
}

/**
 * Whether everything can be read.
 * @param {HTMLElement} box @param {readonly HTMLElement[]} parts @param {number} least
 */
function shrinks(box, parts, least) {
  for (let fit = 1; fit >= least - STEP / 2; fit -= STEP) {
    box.style.setProperty("--fit", fit.toFixed(2));
    if (!parts.some(isCut)) return true;
  }
  return false;
}

/** @param {HTMLElement} part */
function isCut(part) {
  if (part.clientWidth <= 1) return false; // words for screen readers alone
  return part.scrollHeight > part.clientHeight || part.scrollWidth > part.clientWidth;
}
