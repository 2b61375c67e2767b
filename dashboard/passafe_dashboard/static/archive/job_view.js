// Shows a job's progress, then the report that it made, in the page.

import { openReport } from "../report/report.js";
import { element, reason } from "./page_parts.js";
import { ask, followJob } from "./server.js";

/** Shows why there is nothing to show.
 * @param {string} text */
export function showTrouble(text) {
  element("job").hidden = true;
  const trouble = element("job-trouble");
  trouble.hidden = false;
  /** @type {HTMLElement} */ (trouble.firstElementChild).textContent = text;
  document.body.dataset.ready = "trouble";
}

/** Shows progress, and returns the job when it is done; null after trouble, which is shown.
 * @param {any} job routes/jobs.py */
export async function watchJob(job) {
  const cancel = element("job-cancel");
  cancel.onclick = () => ask(`/api/jobs/${job.job}`, { method: "DELETE" }).catch((error) => showTrouble(reason(error)));
  const over = await followJob(job.job, ({ share, text }) => {
    /** @type {HTMLProgressElement} */ (element("job-share")).value = share;
    element("job-text").textContent = text;
  });
  if (over.state !== "done") {
    showTrouble(over.text);
    return null;
  }
  return over;
}

/** Puts the report of a job into the page.
 * @param {any} job a job that is done */
export async function showReport(job) {
  const { markup, data } = await ask(job.result);
  element("report").innerHTML = markup;
  element("job").hidden = true;
  await openReport(data, document);
}
