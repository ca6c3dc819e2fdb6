// From a stick to a seat's input. Pure.
// Directions on a stick: x right, y up, length at most 1. Headings: 0 looks along +y, counter-clockwise, radians.

/** @typedef {{x: number, y: number}} Stick */
/** @typedef {{move: number, heading: number}} Drive  move in [-1, 1], negative is backward */

/** @type {Readonly<Stick>} */
export const CENTRED = Object.freeze({ x: 0, y: 0 });

/**
 * The round dead zone of the official collector: below `zone` nothing, above it rescaled to the full range.
 * @param {number} x @param {number} y @param {number} zone @returns {Stick}
 */
export function withDeadZone(x, y, zone) {
  const length = Math.hypot(x, y);
  if (!(length > zone)) return CENTRED;
  const scaled = Math.min(1, (length - zone) / (1 - zone));
  return { x: (x / length) * scaled, y: (y / length) * scaled };
}

/**
 * The longer of several sticks, so that two devices of one person do not add up.
 * @param {readonly Stick[]} sticks
 * @returns {Stick}
 */
export function strongest(sticks) {
  return sticks.reduce((best, stick) => (lengthOf(stick) > lengthOf(best) ? stick : best), CENTRED);
}

/**
 * The robot moves where the stick points. Driving backward it faces the other way and moves with a negative
 * distance, so it still moves where the stick points. A centred stick keeps the heading.
 * @param {Stick} stick @param {boolean} backward @param {number} lastHeading @returns {Drive}
 */
export function driveFrom(stick, backward, lastHeading) {
  const length = Math.min(1, lengthOf(stick));
  if (length === 0) return { move: 0, heading: lastHeading };
  const heading = Math.atan2(-stick.x, stick.y);
  return backward ? { move: -length, heading: wrap(heading + Math.PI) } : { move: length, heading };
}

/** @param {Stick} stick */
export function lengthOf(stick) {
  return Math.hypot(stick.x, stick.y);
}

/** An angle in [-pi, pi). @param {number} angle */
function wrap(angle) {
  return angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));
}
