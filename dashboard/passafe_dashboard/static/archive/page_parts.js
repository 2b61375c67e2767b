// Small parts of which lists and maps are made.

import { serverSeconds } from "./server_clock.js";

/** @param {string} id
 * @returns {HTMLElement} */
export function element(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/** @param {string} text
 * @param {string} className */
export function tableCell(text, className = "") {
  return Object.assign(document.createElement("td"), { textContent: text, className });
}

/** @param {string} text
 * @param {"col" | "row"} scope */
export function tableHead(text, scope) {
  return Object.assign(document.createElement("th"), { textContent: text, scope });
}

/** Returns what an error says.
 * @param {unknown} error */
export function reason(error) {
  return error instanceof Error ? error.message : String(error);
}

/** @param {number} bytes */
export function sizeText(bytes) {
  if (bytes < 1e5) return `${(bytes / 1e3).toFixed(1)} kB`;
  return bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(2)} GB`;
}

/** @param {number} seconds Unix time
 * @param {number} now the same */
export function timeAgo(seconds, now = serverSeconds()) {
  const ago = Math.max(0, now - seconds);
  if (ago < 60) return "just now";
  if (ago < 3600) return `${Math.floor(ago / 60)} min ago`;
  if (ago < 86_400) return `${Math.floor(ago / 3600)} h ago`;
  return new Date(seconds * 1000).toISOString().slice(0, 10);
}
