// The page of one experiment: its map fills in while it runs; a cell leads to its worst run.

import { numberText } from "../report/number_text.js";
import { element, reason, tableCell, tableHead } from "./page_parts.js";
import { ask, followJob, pathOf, startJob } from "./server.js";
import { offerControl, showControl } from "./sweep_control.js";
import { acrossOf, cellText, rowsOf, shareWord } from "./sweep_map.js";

const REFRESH_MS = 1000;
const RESTING_MS = 5000;
const MOST_ROWS = 400;
const RUNNING = ["running", "writing logs", "writing its report"];

const name = element("name").textContent ?? "";
const criterion = /** @type {HTMLSelectElement} */ (element("criterion"));
/** @type {any} */
let view = null;
let shown = "";
/** @type {number | null} */
let chosen = null;

/** @param {any} entry */
function showProgress(entry) {
  element("title").textContent = entry.title || name;
  element("stage").textContent = entry.stage;
  element("stage").className = `state ${entry.stage.replaceAll(" ", "-")}`;
  const all = entry.most_runs ? ` of ${entry.most_runs}` : "";
  element("counts").textContent = `${entry.runs}${all} runs${view.is_behind ? ", still reading them" : ""}`;
  const bar = /** @type {HTMLProgressElement} */ (element("share"));
  bar.hidden = !entry.most_runs || !RUNNING.includes(entry.stage);
  bar.value = entry.most_runs ? entry.runs / entry.most_runs : 0;
  showControl(entry);
}

function offerCriteria() {
  if (criterion.options.length) return;
  criterion.append(...Object.keys(view.criteria).map((key) => new Option(key, key)));
  criterion.value = view.worst_by;
  criterion.addEventListener("change", showMap);
}

function mapOptions() {
  const metric = view.metrics[criterion.value];
  return { metric, worstIsHigh: view.criteria[criterion.value].includes("≤"), seeds: view.seeds, bisected: view.bisected !== null };
}

/** @param {any} cell
 * @param {any} options */
function cellOf(cell, options) {
  const { main, note } = cellText(cell, criterion.value, options);
  const button = Object.assign(document.createElement("button"), { type: "button", className: "map-cell" });
  button.dataset.cell = String(cell.number);
  button.dataset.share = shareWord(cell, criterion.value);
  button.disabled = !cell.probes.length;
  if (cell.number === chosen) button.setAttribute("aria-current", "true");
  button.append(Object.assign(document.createElement("span"), { textContent: main }));
  if (note) button.append(Object.assign(document.createElement("small"), { textContent: note }));
  const box = document.createElement("td");
  box.append(button);
  return box;
}

function showMap() {
  const across = acrossOf(view.axes);
  const axis = across < 0 ? { name: "", values: [""] } : view.axes[across];
  const options = mapOptions();
  const what = options.bisected ? `where ${criterion.value} first fails along ${view.bisected}` : `worst ${options.metric ?? "verdict"} of each cell`;
  element("map-caption").textContent = `${what[0].toUpperCase()}${what.slice(1)}${axis.name ? `, over ${axis.name}` : ""}`;
  element("asked").textContent = `asked: ${view.criteria[criterion.value]}`;
  const head = document.createElement("tr");
  head.append(tableHead(axis.name ? `${axis.name} →` : "", "col"), ...axis.values.map((/** @type {string} */ value) => tableHead(value, "col")));
  const rows = rowsOf(view.cells, view.axes, view.variants);
  const lines = rows.slice(0, MOST_ROWS).map((row) => {
    const line = document.createElement("tr");
    line.append(tableHead(row.head, "row"), ...row.cells.map((cell) => cellOf(cell, options)));
    return line;
  });
  const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset?.cell;
  const map = element("map");
  /** @type {HTMLElement} */ (map.querySelector("thead")).replaceChildren(head);
  /** @type {HTMLElement} */ (map.querySelector("tbody")).replaceChildren(...lines);
  if (focused) /** @type {HTMLElement | null} */ (map.querySelector(`[data-cell="${focused}"]`))?.focus();
  if (rows.length > MOST_ROWS) element("map-caption").textContent += ` (${rows.length - MOST_ROWS} more rows in cells.csv)`;
  element("map-section").hidden = false;
}

function showCell() {
  const cell = view.cells.find((/** @type {any} */ each) => each.number === chosen);
  if (!cell) return;
  const values = view.axes.map((/** @type {any} */ axis, /** @type {number} */ k) => `${axis.name} ${cell.values[k]}`);
  element("cell-title").textContent = [`Cell ${cell.number}: ${cell.variant}`, ...values].join(", ");
  const names = Object.keys(view.criteria);
  const metric = view.metrics[view.worst_by];
  const head = document.createElement("tr");
  const columns = [...(view.bisected ? [view.bisected] : []), "runs", ...names.map((each) => `break ${each}`), `worst ${metric}`, "worst run"];
  head.append(...columns.map((text) => tableHead(text, "col")));
  const lines = cell.probes.map((/** @type {any} */ probe) => probeRow(cell, probe, names));
  const table = element("probes");
  /** @type {HTMLElement} */ (table.querySelector("thead")).replaceChildren(head);
  /** @type {HTMLElement} */ (table.querySelector("tbody")).replaceChildren(...lines);
  element("cell").hidden = false;
}

/** @param {any} cell
 * @param {any} probe
 * @param {string[]} names */
function probeRow(cell, probe, names) {
  const row = document.createElement("tr");
  if (view.bisected) row.append(tableCell(numberText(probe.probe, 4)));
  const errors = probe.errors ? ` (${probe.errors} could not be run)` : "";
  row.append(tableCell(`${probe.runs}${errors}`), ...names.map((each) => tableCell(String(probe.breaking[each] ?? 0))));
  row.append(tableCell(probe.worst === null ? "unknown" : numberText(probe.worst)));
  const open = document.createElement("td");
  if (probe.log) {
    const href = `/logs/${pathOf(probe.log)}`;
    open.append(Object.assign(document.createElement("a"), { href, className: "open-run", textContent: `Open seed ${probe.worst_seed}` }));
  } else {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "open-run", textContent: `Run seed ${probe.worst_seed} again and open it` });
    button.disabled = probe.errors === probe.runs;
    button.addEventListener("click", () => repeat(button, { kind: "cell-run", experiment: name, cell: cell.number, probe: probe.probe, seed: probe.worst_seed }));
    open.append(button);
  }
  row.append(open);
  return row;
}

/** @param {HTMLButtonElement} button
 * @param {any} request */
async function repeat(button, request) {
  const answer = element("cell-answer");
  button.disabled = true;
  try {
    const job = await startJob(request);
    const over = await followJob(job.job, ({ text, share }) => {
      answer.textContent = `${text} (${Math.round(100 * share)} %)`;
    });
    if (over.state !== "done") throw new Error(over.text);
    location.href = `/logs/${pathOf(over.log)}`;
  } catch (error) {
    answer.textContent = reason(error);
    button.disabled = false;
  }
}

async function look() {
  const trouble = element("trouble");
  try {
    view = await ask(`/api/experiments/${pathOf(name)}`);
    const text = JSON.stringify(view);
    if (text !== shown) {
      shown = text;
      showProgress(view.entry);
      offerCriteria();
      showMap();
      if (!document.activeElement?.classList.contains("open-run")) showCell();
    }
    trouble.hidden = true;
    document.body.dataset.ready = "true";
  } catch (error) {
    trouble.hidden = false;
    /** @type {HTMLElement} */ (trouble.firstElementChild).textContent = reason(error);
    document.body.dataset.ready = "trouble";
  }
}

async function refresh() {
  await look();
  const runs = RUNNING.includes(view?.entry.stage) || view?.is_behind;
  setTimeout(refresh, runs ? REFRESH_MS : RESTING_MS);
}

element("map").addEventListener("click", (event) => {
  const button = /** @type {HTMLElement} */ (event.target).closest("[data-cell]");
  if (!button) return;
  chosen = Number(/** @type {HTMLElement} */ (button).dataset.cell);
  element("cell-answer").textContent = "";
  showMap();
  showCell();
  element("cell").scrollIntoView({ block: "nearest" });
});
offerControl(name, () => view.entry, look);
refresh();
