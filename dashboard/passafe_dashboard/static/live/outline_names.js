// Which names of outlines can be written so that each is read: none over another, none over a neighbour.

/** @typedef {import("./types.js").Pair} Pair
 * @typedef {{low: Pair, high: Pair}} Box corners of an upright rectangle, pixels */

/** A name in the middle of an outline.
 * @typedef {{text: string, width: number, outline: Box, nearest: boolean}} OutlineName */

const LINE_PX = 14;

/** Returns the rectangle around places.
 * @param {Pair[]} places
 * @returns {Box} */
export function boxAround(places) {
  /** @param {(...values: number[]) => number} of
   * @returns {Pair} */
  const corner = (of) => [of(...places.map(([x]) => x)), of(...places.map(([, y]) => y))];
  return { low: corner(Math.min), high: corner(Math.max) };
}

/** @param {Box} box
 * @returns {Pair} */
export function middle({ low, high }) {
  return [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
}

/** @param {Box} a
 * @param {Box} b */
function overlap(a, b) {
  return [0, 1].every((axis) => a.low[axis] < b.high[axis] && b.low[axis] < a.high[axis]);
}

/** Returns the names to write: that of the nearest limit, and of the others those that cover no name and no outline beside theirs.
 * @param {OutlineName[]} names in the scenario's order
 * @returns {OutlineName[]} */
export function readableNames(names) {
  /** @type {Box[]} */
  const written = [];
  const first = [...names].sort((a, b) => Number(b.nearest) - Number(a.nearest));
  return first.filter(({ width, outline, nearest }) => {
    const [x, y] = middle(outline);
    /** @type {Box} */
    const box = { low: [x - width / 2, y - LINE_PX / 2], high: [x + width / 2, y + LINE_PX / 2] };
    const beside = names.map((other) => other.outline).filter((other) => !overlap(other, { low: [x, y], high: [x, y] }));
    if (!nearest && [...written, ...beside].some((other) => overlap(other, box))) return false;
    written.push(box);
    return true;
  });
}
