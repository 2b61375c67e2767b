// The map of an experiment as rows and columns: the longest listed axis across, everything else down.

import { numberText } from "../report/number_text.js";

/** @typedef {{probe: number | null, runs: number, errors: number, breaking: Record<string, number>,
 *   low: Record<string, number>, high: Record<string, number>, worst_seed: number, worst: number | null,
 *   log: string | null}} Probe */

/** @typedef {{number: number, variant: string, values: string[], probes: Probe[],
 *   boundaries: Record<string, string>}} Cell */

/** @typedef {{head: string, cells: Cell[]}} MapRow */

/** Returns number of the axis that runs across; −1 without listed axes.
 * @param {{values: string[]}[]} axes */
export function acrossOf(axes) {
  let across = -1;
  axes.forEach((axis, number) => {
    if (across < 0 || axis.values.length > axes[across].values.length) across = number;
  });
  return across;
}

/** Returns the rows of the map.
 * @param {Cell[]} cells
 * @param {{name: string, values: string[]}[]} axes
 * @param {string[]} variants
 * @returns {MapRow[]} */
export function rowsOf(cells, axes, variants) {
  const across = acrossOf(axes);
  /** @type {Map<string, MapRow>} */
  const rows = new Map();
  for (const cell of cells) {
    const others = axes.flatMap(({ name }, number) => (number === across ? [] : [`${name} ${cell.values[number]}`]));
    const head = [...(variants.length > 1 ? [cell.variant] : []), ...others].join(", ") || cell.variant;
    const row = rows.get(head) ?? { head, cells: [] };
    row.cells.push(cell);
    rows.set(head, row);
  }
  return [...rows.values()];
}

/** Returns runs of a cell, and how many of them break a criterion.
 * @param {Cell} cell
 * @param {string} criterion */
export function brokenOf(cell, criterion) {
  let [runs, broken] = [0, 0];
  for (const probe of cell.probes) {
    runs += probe.runs;
    broken += probe.breaking[criterion] ?? 0;
  }
  return { runs, broken };
}

/** Returns the share of a cell's runs that break a criterion as a word: unknown, none, some, all.
 * @param {Cell} cell
 * @param {string} criterion */
export function shareWord(cell, criterion) {
  const { runs, broken } = brokenOf(cell, criterion);
  if (!runs) return "unknown";
  if (!broken) return "none";
  return broken < runs ? "some" : "all";
}

/** Returns what stands in a cell of the map.
 * @param {Cell} cell
 * @param {string} criterion
 * @param {{metric: string | undefined, worstIsHigh: boolean, seeds: number | null, bisected: boolean}} map */
export function cellText(cell, criterion, map) {
  const { runs, broken } = brokenOf(cell, criterion);
  if (!runs) return { main: "–", note: "" };
  if (map.bisected) {
    const text = cell.boundaries[criterion];
    return { main: text ?? (broken ? `${broken} of ${runs} break` : "none breaks"), note: `${cell.probes.length} values` };
  }
  const [probe] = cell.probes;
  const worst = map.metric === undefined ? undefined : (map.worstIsHigh ? probe.high : probe.low)[map.metric];
  const share = broken ? `${broken} of ${runs} break` : `none of ${runs}`;
  const missing = map.seeds && runs < map.seeds ? `, ${map.seeds - runs} to come` : "";
  return { main: worst === undefined ? share : numberText(worst), note: worst === undefined ? missing.slice(2) : share + missing };
}
