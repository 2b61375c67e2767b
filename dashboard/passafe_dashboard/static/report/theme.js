// Colours and dashes of plots, from the style sheet, so that light and dark pages differ in one place only.

export const LINES = 5;
/** @type {number[][]} */
const DASHES = [[], [7, 4], [8, 3, 2, 3], [2, 3], [10, 3, 2, 3, 2, 3]];

/** @typedef {{ink: string, quiet: string, paper: string, grid: string, unsafe: string, lines: string[]}} Theme */

/** @returns {Theme} */
export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const colour = (/** @type {string} */ name) => style.getPropertyValue(`--${name}`).trim();
  return {
    ink: colour("ink"),
    quiet: colour("quiet"),
    paper: colour("paper"),
    grid: colour("grid"),
    unsafe: colour("unsafe"),
    lines: Array.from({ length: LINES }, (_, i) => colour(`series-${i}`)),
  };
}

/** Returns the dash of a line: for what was asked, for lines that cross one another, and where colours repeat.
 * @param {Pick<import("./payload.js").ChartPlan, "choices">} plan
 * @param {Pick<import("./payload.js").PlannedLine, "dash" | "style">} line
 * @returns {number[]} */
export function lineDash(plan, line) {
  if (line.dash) return [5, 4];
  const round = Math.floor(line.style / LINES);
  return plan.choices.length || round ? DASHES[(line.style + round) % DASHES.length] : [];
}

/** Calls back when the reader's system turns dark or light.
 * @param {() => void} changed */
export function onThemeChange(changed) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
}
