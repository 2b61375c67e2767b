// Colours of the live page's pictures, from its style sheet.

import { readTheme } from "../report/theme.js";

const NAMES = /** @type {const} */ (["accent", "held", "raised", "sunken", "line", "unsafe-wash"]);

/** @typedef {import("../report/theme.js").Theme & Record<typeof NAMES[number], string>} LiveTheme */

/** @returns {LiveTheme} */
export function readLiveTheme() {
  const style = getComputedStyle(document.documentElement);
  const colours = NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]);
  return { ...readTheme(), .../** @type {Record<typeof NAMES[number], string>} */ (Object.fromEntries(colours)) };
}
