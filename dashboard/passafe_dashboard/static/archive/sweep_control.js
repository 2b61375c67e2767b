// Stops the sweep of an experiment, and resumes one that was stopped.

import { element, reason } from "./page_parts.js";
import { ask, startJob } from "./server.js";

const OPEN = ["waiting", "running"];

/** Shows what may be done with an experiment now, and what became of its last sweep.
 * @param {any} entry archive/experiment_models.py */
export function showControl(entry) {
  const isOpen = OPEN.includes(entry.job?.state);
  element("sweep-stop").hidden = !isOpen;
  element("sweep-resume").hidden = isOpen || entry.stage !== "interrupted";
  const said = element("sweep-said");
  const failed = entry.job?.state === "failed";
  const words = isOpen || entry.job?.state === "cancelled" || entry.job?.text === "done" ? "" : (entry.job?.text ?? "");
  said.textContent = failed ? `It ended: ${words}` : words;
  said.classList.toggle("bad", failed);
}

/** Lets the buttons act.
 * @param {string} name of the experiment
 * @param {() => any} entryOf
 * @param {() => Promise<void>} refresh */
export function offerControl(name, entryOf, refresh) {
  const stop = /** @type {HTMLButtonElement} */ (element("sweep-stop"));
  const resume = /** @type {HTMLButtonElement} */ (element("sweep-resume"));
  /** @param {HTMLButtonElement} button
   * @param {() => Promise<any>} act */
  const act = (button, act) =>
    button.addEventListener("click", async () => {
      element("sweep-answer").textContent = "";
      button.disabled = true;
      try {
        await act();
      } catch (error) {
        element("sweep-answer").textContent = reason(error);
      }
      await refresh();
      button.disabled = false;
    });
  act(stop, () => ask(`/api/jobs/${encodeURIComponent(entryOf().job.job)}`, { method: "DELETE" }));
  act(resume, () => startJob({ kind: "sweep", source: "folder", experiment: name }));
}
