// The list of experiments, kept current.

import { element, reason, tableCell, timeAgo } from "./page_parts.js";
import { ask, pathOf } from "./server.js";
import { offerExperiments } from "./start_experiment.js";

const REFRESH_MS = 2000;
let shown = "";

/** @param {any} entry archive/experiment_view.py */
function rowOf(entry) {
  const row = document.createElement("tr");
  const name = Object.assign(document.createElement("th"), { scope: "row" });
  const href = `/experiments/${pathOf(entry.name)}`;
  name.append(Object.assign(document.createElement("a"), { href, textContent: entry.name }));
  const runs = entry.most_runs ? `${entry.runs} of ${entry.most_runs}` : String(entry.runs);
  const state = tableCell(entry.trouble || entry.stage, `state ${entry.trouble ? "torn" : entry.stage.replaceAll(" ", "-")}`);
  row.append(name, tableCell(entry.title), state, tableCell(runs), tableCell(timeAgo(entry.modified_s)));
  return row;
}

async function refresh() {
  const none = element("none");
  try {
    const { experiments } = await ask("/api/experiments");
    const text = JSON.stringify(experiments.map((/** @type {any} */ entry) => [entry, timeAgo(entry.modified_s)]));
    if (text !== shown) {
      shown = text;
      const held = document.activeElement?.textContent;
      const body = /** @type {HTMLElement} */ (document.querySelector("#experiments tbody"));
      body.replaceChildren(...experiments.map(rowOf));
      for (const link of body.querySelectorAll("a")) if (link.textContent === held) link.focus();
    }
    none.hidden = experiments.length > 0;
    none.textContent = "No experiments yet.";
    document.body.dataset.ready = "true";
  } catch (error) {
    none.hidden = false;
    none.textContent = reason(error);
  }
  setTimeout(refresh, REFRESH_MS);
}

refresh();
offerExperiments().catch((error) => {
  element("none").textContent = reason(error);
});
