// The outlines of items, in arena units around their centre, first vertex on +y (the Python twin is
// maps/shapes.py). A circle has no outline: draw it by `radiusOf`.

const SIDES = new Map([
  ["triangle", 3],
  ["pentagon", 5],
  ["hexagon", 6],
  ["octagon", 8],
]);

const TRIANGLE_SHRINK = 0.8;
const STAR_OUTER = 1.3;
const STAR_INNER = 0.65;

/** @typedef {[number, number]} Point */

/**
 * The corners of an item, counter-clockwise; empty for a circle.
 * @param {string} shape  one of triangle, square, rectangle, pentagon, hexagon, octagon, star, circle
 * @param {number} scale  radius of the circle that has the item's area
 * @returns {Point[]}
 */
export function outline(shape, scale) {
  if (shape === "circle") return [];
  const side = Math.sqrt(Math.PI) * scale;
  if (shape === "square") return box(side, side);
  if (shape === "rectangle") return box(side, side / 2);
  if (shape === "star") {
    return ring(10, (corner) => (corner % 2 === 0 ? STAR_OUTER : STAR_INNER) * scale);
  }
  const sides = SIDES.get(shape);
  if (sides === undefined) throw new RangeError(`unknown shape ${shape}`);
  const radius = polygonRadius(sides, scale) * (shape === "triangle" ? TRIANGLE_SHRINK : 1);
  return ring(sides, () => radius);
}

/**
 * The distance from the centre to the farthest point of an item.
 * @param {string} shape
 * @param {number} scale
 */
export function radiusOf(shape, scale) {
  if (shape === "circle") return scale;
  return Math.max(...outline(shape, scale).map(([x, y]) => Math.hypot(x, y)));
}

/** @param {number} width @param {number} height @returns {Point[]} */
function box(width, height) {
  const [x, y] = [width / 2, height / 2];
  return [
    [x, y],
    [-x, y],
    [-x, -y],
    [x, -y],
  ];
}

/** @param {number} corners @param {(corner: number) => number} radiusAt @returns {Point[]} */
function ring(corners, radiusAt) {
  return Array.from({ length: corners }, (_, corner) => {
    const angle = (2 * Math.PI * corner) / corners;
    return [-radiusAt(corner) * Math.sin(angle), radiusAt(corner) * Math.cos(angle)];
  });
}

/** Circumradius of the regular polygon whose area is pi scale². @param {number} sides @param {number} scale */
function polygonRadius(sides, scale) {
  const half = Math.PI / sides;
  const side = 2 * scale * Math.sqrt(half * Math.tan(half));
  return side / (2 * Math.sin(half));
}
