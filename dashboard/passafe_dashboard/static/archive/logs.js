// The list of logs, the newest first, kept current; two of them can be compared.

import { element, reason, sizeText, tableCell, timeAgo } from "./page_parts.js";
import { ask, pathOf } from "./server.js";

const REFRESH_MS = 3000;
const body = /** @type {HTMLElement} */ (document.querySelector("#logs tbody"));
const find = /** @type {HTMLInputElement} */ (element("find"));
const compare = /** @type {HTMLButtonElement} */ (element("compare"));
/** @type {Map<string, HTMLTableRowElement>} */
const rows = new Map();
/** @type {string[]} */
let chosen = [];
let shown = "";

/** @param {any} log archive/log_list.py */
function rowOf(log) {
  const row = document.createElement("tr");
  const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: chosen.includes(log.name) });
  box.setAttribute("aria-label", `compare ${log.name}`);
  box.addEventListener("change", () => choose(log.name, box.checked));
  const mark = tableCell("");
  if (log.state !== "no log") mark.append(box);
  const name = Object.assign(document.createElement("th"), { scope: "row" });
  const link = Object.assign(document.createElement("a"), { href: `/logs/${pathOf(log.name)}`, textContent: log.name });
  name.append(link);
  if (log.source) {
    const text = `what if of ${log.source}: ${log.changes.join("; ") || "nothing changed"}`;
    name.append(Object.assign(document.createElement("div"), { className: "note", textContent: text }));
  }
  const files = log.files > 1 ? `, ${log.files} files` : "";
  const state = tableCell(log.state, log.state === "finished" ? "quiet" : `state ${log.state.replace(" ", "-")}`);
  const verdict = tableCell(log.verdict || (log.state === "no log" ? "" : "not reviewed"), "verdict");
  verdict.dataset.outcome = log.verdict;
  const changed = tableCell(timeAgo(log.modified_s));
  changed.title = new Date(log.modified_s * 1000).toISOString();
  row.append(mark, name, tableCell(log.scenario), tableCell(log.mode), state, verdict, tableCell(sizeText(log.size_bytes) + files, "right"), changed);
  return row;
}

/** @param {string} name
 * @param {boolean} on */
function choose(name, on) {
  chosen = on ? [...chosen.filter((other) => other !== name), name].slice(-2) : chosen.filter((other) => other !== name);
  for (const [other, row] of rows) {
    const box = row.querySelector("input");
    if (box) box.checked = chosen.includes(other);
  }
  compare.disabled = chosen.length !== 2;
  const words = ["Mark two logs to compare them.", `${chosen[0]}: mark another one.`, chosen.join(" and ")];
  element("chosen").textContent = words[chosen.length];
}

function filter() {
  const wanted = find.value.toLowerCase().split(/\s+/).filter(Boolean);
  let left = 0;
  for (const row of rows.values()) {
    const text = row.textContent.toLowerCase();
    row.hidden = !wanted.every((word) => text.includes(word));
    if (!row.hidden) left += 1;
  }
  const none = element("none");
  none.hidden = left > 0;
  none.textContent = rows.size ? "No log fits." : "No logs yet: a run that is recorded appears here.";
}

/** @param {any} list archive/log_list.py */
function show(list) {
  element("folder").textContent = list.folder;
  const text = JSON.stringify(list.logs.map((/** @type {any} */ log) => [log, timeAgo(log.modified_s)]));
  if (text !== shown) {
    shown = text;
    const focused = document.activeElement?.closest("tr");
    const held = [...rows].find(([, row]) => row === focused)?.[0];
    const kind = document.activeElement?.tagName ?? "";
    rows.clear();
    for (const log of list.logs) rows.set(log.name, rowOf(log));
    body.replaceChildren(...rows.values());
    if (held) /** @type {HTMLElement} */ (rows.get(held)?.querySelector(kind))?.focus();
  }
  const left = element("left-out");
  left.hidden = !list.left_out;
  left.textContent = `${list.left_out} older ones are not listed.`;
  filter();
}

async function refresh() {
  try {
    show(await ask("/api/logs"));
    document.body.dataset.ready = "true";
  } catch (error) {
    const none = element("none");
    none.hidden = false;
    none.textContent = reason(error);
  }
  setTimeout(refresh, REFRESH_MS);
}

find.addEventListener("input", filter);
compare.addEventListener("click", () => {
  location.href = `/compare?${chosen.map((name) => `log=${encodeURIComponent(name)}`).join("&")}`;
});
refresh();
