// The page of a job that was started elsewhere, such as a what-if: progress, then its result.

import { showReport, showTrouble, watchJob } from "./job_view.js";
import { element, reason } from "./page_parts.js";
import { ask, pathOf } from "./server.js";

/** @param {string} text
 * @param {string} name */
function linkTo(text, name) {
  const link = document.createElement("a");
  link.href = `/logs/${pathOf(name)}`;
  link.textContent = text;
  return link;
}

async function open() {
  const job = await ask(`/api/jobs/${encodeURIComponent(element("report").dataset.job ?? "")}`);
  if (job.request.log) element("origin").append(linkTo(job.request.log, job.request.log), " / what if");
  const done = await watchJob(job);
  if (!done) return;
  if (done.log) {
    const made = element("made");
    made.append("The re-run is a log of its own: ", linkTo(done.log, done.log));
    made.hidden = false;
  }
  await showReport(done);
}

open().catch((error) => showTrouble(reason(error)));
