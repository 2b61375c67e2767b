// The page of one log: its review, drawn when it is made, and what if something had been different.

import { showReport, showTrouble, watchJob } from "./job_view.js";
import { element, reason } from "./page_parts.js";
import { ask, pathOf, startJob } from "./server.js";
import { offerWhatIf } from "./what_if.js";

const name = element("name").textContent ?? "";
/** @type {Record<string, string>} */
const STATES = {
  finished: "",
  recording: "is being recorded: this is the run up to now",
  torn: "is torn: its end is missing",
  "no log": "",
};

async function open() {
  const entry = await ask(`/api/logs/${pathOf(name)}`);
  element("state").textContent = STATES[entry.state] ?? "";
  const done = await watchJob(await startJob({ kind: "review", log: name }));
  if (!done) return;
  await showReport(done);
  // The first mark is the worst moment: a violated property, or the lowest barrier.
  if (location.hash === "#worst") /** @type {HTMLElement | null} */ (document.querySelector(".marks [data-jump]"))?.click();
  offerWhatIf(name);
}

open().catch((error) => showTrouble(reason(error)));
