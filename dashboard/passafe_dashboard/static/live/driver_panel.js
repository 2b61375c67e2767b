// Who drives, the lease, and what is recorded.

import { byId, setText } from "./elements.js";

/** @typedef {import("./types.js").Now} Now */

/** Returns who drives, in words.
 * @param {import("./types.js").Driver | undefined} driver
 * @param {boolean} you whether it is this page
 * @param {string | undefined} script kind of the scenario's own source */
export function driverText(driver, you, script) {
  if (you) return "you, from this page";
  if (!driver) return "nobody";
  if (driver.page) return `page ${driver.page}`;
  return driver.device === script ? `the script (${script})` : `the ${driver.device}`;
}

/** Returns what moves the robot after a clear of the emergency stop.
 * @param {import("./types.js").Driver | undefined} driver
 * @param {boolean} you
 * @param {string | undefined} script */
export function afterClearText(driver, you, script) {
  const pull = "Its own controller moves it as soon as the stop is cleared";
  if (you) return `${pull}; let go of stick and keys, then drive on.`;
  return driver ? `${pull}, and ${driverText(driver, false, script)} drives on at once.` : `${pull}; nobody drives.`;
}

/** @param {any} lease */
export function leaseText(lease) {
  if (!lease) return "–";
  const other = lease.refused ? "; another session is refused" : "";
  if (!lease.holder) return `free${other}`;
  const silence = lease.heartbeat_ms > 500 ? `, silent for ${(lease.heartbeat_ms / 1000).toFixed(1)} s` : "";
  return `held by ${lease.device}${silence}${other}`;
}

/** @param {Now} now */
export function recordingText(now) {
  if (now.session?.state === "stopped") return "no run";
  if (now.session) return now.session.recording ? `on, ${now.session.log ?? "the log is being opened"}` : "off";
  const recorder = now.processes.find((each) => each.process === "recorder");
  return recorder?.state === "ok" ? "on" : recorder?.state === "silent" ? "the recorder is silent" : "off";
}

/** @param {Now} now
 * @param {boolean} you
 * @param {string | undefined} script */
export function showDriver(now, you, script) {
  const runs = now.session?.state !== "stopped";
  setText(byId("driver"), runs ? driverText(now.drive?.driver, you, script) : "–");
  setText(byId("lease"), runs ? leaseText(now.drive?.lease ?? now.lease) : "–");
  const recording = byId("recording");
  setText(recording, recordingText(now));
  recording.title = recording.textContent ?? "";
}
