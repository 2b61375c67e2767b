// The emergency stop: a button that presses it, and one that clears the stop that the page shows.
// The plant latches the stop; what is shown here is what its states say.
import { setText } from "./readouts.js";

const byId = (id) => document.getElementById(id);
const answer = byId("stop-answer");

let latched = null;

export function showStop({ stop, lease }) {
  if (stop.id !== latched) setText(answer, stop.id ? `Stopped: pressed at ${stop.source}. The fail-safe law is in force.` : "");
  latched = stop.id;
  byId("clear").hidden = !latched;
  document.body.toggleAttribute("data-stopped", Boolean(latched));
  const cell = byId("lease");
  if (cell) setText(cell, leaseText(lease));
}

function leaseText(lease) {
  if (!lease) return "–";
  const other = lease.refused ? "; another session is refused" : "";
  if (!lease.holder) return `free${other}`;
  return `${lease.device}, heartbeat ${Math.round(lease.heartbeat_ms)} ms${other}`;
}

async function request(path, doing) {
  setText(answer, doing);
  try {
    const response = await fetch(path, { method: "PUT" });
    const body = await response.json();
    if (!response.ok) setText(answer, `Failed: ${body.detail}`);
  } catch (error) {
    setText(answer, `Failed: the dashboard does not answer (${error.message}). Use passafe stop, or the robot's own switch.`);
  }
}

byId("stop").addEventListener("click", () => request("/api/stop", "Stopping …"));
byId("clear").addEventListener("click", () => {
  if (latched && window.confirm("Is the way free? The robot can be driven again after the clear.")) {
    request(`/api/clear/${latched}`, "Clearing …");
  }
});
