// The ages of content: of what the filter decided on, and of what the robot was given.

import { byId, setText } from "./elements.js";

const LATE_MS = 60;

/** Returns an age as people read it.
 * @param {number | null | undefined} ms */
export function ageText(ms) {
  if (ms === null || ms === undefined) return "–";
  if (ms < 1) return "< 1 ms";
  if (ms < 1000) return `${Math.round(ms)} ms`;
  return ms < 100_000 ? `${(ms / 1000).toFixed(1)} s` : `${Math.round(ms / 60_000)} min`;
}

/** @param {import("./types.js").Ages | undefined} ages */
export function showDelays(ages) {
  const values = { "to-robot": ages?.to_robot_ms, "from-robot": ages?.from_robot_ms, "round-trip": ages?.round_trip_ms };
  for (const [id, ms] of Object.entries(values)) {
    const cell = byId(id);
    setText(cell, ageText(ms));
    cell.classList.toggle("late", (ms ?? 0) > LATE_MS);
  }
}
