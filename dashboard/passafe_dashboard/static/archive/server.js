// Asks the server, and follows jobs until they are over.

import { reason } from "./page_parts.js";
import { noteClock } from "./server_clock.js";

/** Returns the answer's JSON; an error carries what the server said.
 * @param {string} path
 * @param {RequestInit} [options]
 * @returns {Promise<any>} */
export async function ask(path, options = {}) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    throw new Error(`The server does not answer (${reason(error)}).`);
  }
  noteClock(response);
  const body = await response.json().catch(() => null);
  if (!response.ok) throw new Error(refusal(body?.detail, response.status));
  return body;
}

/** @param {any} detail
 * @param {number} status */
function refusal(detail, status) {
  if (typeof detail === "string") return detail;
  if (Array.isArray(detail)) return detail.map(({ loc, msg }) => `${loc.at(-1)}: ${msg.replace(/^Value error, /, "")}`).join("; ");
  return `The server refused it (${status}).`;
}

/** Returns the address of a name with folders.
 * @param {string} name */
export function pathOf(name) {
  return name.split("/").map(encodeURIComponent).join("/");
}

/** @param {any} request jobs/job_request.py */
export function startJob(request) {
  const headers = { "Content-Type": "application/json" };
  return ask("/api/jobs", { method: "POST", headers, body: JSON.stringify(request) });
}

/** Follows a job until it is over, or as far as it is waited for.
 * @param {string} id
 * @param {(job: any) => void} onChange
 * @param {(job: any) => boolean} isFarEnough
 * @returns {Promise<any>} the job then */
export async function followJob(id, onChange, isFarEnough = () => false) {
  let seen = -1;
  for (;;) {
    const job = await ask(`/api/jobs/${encodeURIComponent(id)}?seen=${seen}`);
    onChange(job);
    if (!["waiting", "running"].includes(job.state) || isFarEnough(job)) return job;
    seen = job.changes;
  }
}
