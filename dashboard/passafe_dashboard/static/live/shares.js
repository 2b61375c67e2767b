// From hands to the axes of the operator's input: which source steers, and what each axis gets.

/** @typedef {import("./types.js").Pair} Pair */

/** A source of commands: a value for each plane while it is engaged.
 * @typedef {{engaged: boolean, values: Pair[]}} Source */

/** Returns the command of the first source that is engaged.
 * @param {Source[]} sources in order of precedence
 * @param {number} pads
 * @returns {Source} */
export function firstEngaged(sources, pads) {
  return sources.find(({ engaged }) => engaged) ?? { engaged: false, values: Array.from({ length: pads }, () => [0, 0]) };
}

/** Returns the share of a full command for each axis.
 * @param {Pair[]} values one for each plane
 * @param {number[][]} pairs axes of each plane
 * @param {number} axes
 * @returns {number[]} */
export function axisShares(values, pairs, axes) {
  const shares = Array.from({ length: axes }, () => 0);
  pairs.forEach((pair, pad) => {
    pair.forEach((axis, i) => {
      shares[axis] = Math.min(Math.max(values[pad]?.[i] ?? 0, -1), 1);
    });
  });
  return shares;
}
