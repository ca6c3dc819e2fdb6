// @ts-check
/*
 * Rectangles of a canvas.
 */

/** @typedef {{left: number, top: number, right: number, bottom: number}} Box  whole pixels */

/** @param {Box} one @param {Box} other */
export function overlap(one, other) {
  return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
}

/** @param {Box} one @param {Box} other @returns {Box} */
export function union(one, other) {
  return {
    left: Math.min(one.left, other.left),
    top: Math.min(one.top, other.top),
    right: Math.max(one.right, other.right),
    bottom: Math.max(one.bottom, other.bottom),
  };
}

/** Boxes that hold the same places and do not overlap. @param {readonly Box[]} boxes @returns {Box[]} */
export function apart(boxes) {
  /** @type {Box[]} */
  let done = [];
  for (const one of boxes) {
    let box = one;
    for (let near = done.filter((other) => overlap(box, other)); near.length > 0;) {
      done = done.filter((other) => !near.includes(other));
      box = near.reduce(union, box);
      near = done.filter((other) => overlap(box, other));
    }
    done.push(box);
  }
  return done;
}
