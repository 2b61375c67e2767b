// The processes of a demo: is each alive; kill one, restart it.

import { byId, element, setText } from "./elements.js";
import { request } from "./requests.js";

/** @typedef {import("./types.js").Now} Now */

/** Returns a process's state in words.
 * @param {any} process
 * @param {string | undefined} supervised its state at the demo's supervisor; missing: it is not part of the run
 * @param {boolean} hasSession */
export function processText(process, supervised, hasSession) {
  if (hasSession && !supervised) return "not part of this run";
  if (supervised === "down") return "down until restarted";
  if (process.state === "no report") return "not running, or no report yet";
  if (process.state === "silent") return `silent for ${process.age_s.toFixed(1)} s`;
  return `${process.rate_hz.toFixed(0)} steps a second`;
}

export class ProcessPanel {
  constructor() {
    this.answer = byId("panel-answer");
    this.list = element("div", "process-list");
    this.note = element("p", "run-note");
    byId("panel-processes").replaceChildren(this.list, this.note);
    /** @type {Map<string, {state: HTMLElement, kill: HTMLButtonElement, restart: HTMLButtonElement}>} */
    this.rows = new Map();
  }

  /** @param {Now} now */
  show(now) {
    const offered = now.session?.processes ?? {};
    setText(this.note, now.session ? "" : "This system was not started by a demo: its processes are not controlled from here.");
    for (const process of now.processes) {
      const row = this.rows.get(process.process) ?? this.add(process.process);
      const supervised = offered[process.process]?.state;
      const text = processText(process, supervised, Boolean(now.session));
      setText(row.state, text);
      row.state.classList.toggle("bad", text.startsWith("silent") || supervised === "down");
      const can = offered[process.process]?.can ?? [];
      row.kill.disabled = !can.includes("kill");
      row.restart.disabled = !can.includes("restart");
    }
  }

  /** @param {string} name */
  add(name) {
    const state = element("span");
    const [kill, restart] = ["kill", "restart"].map((action) => {
      const button = /** @type {HTMLButtonElement} */ (element("button", "", action === "kill" ? "Kill" : "Restart"));
      button.type = "button";
      button.setAttribute("aria-label", `${action} ${name}`);
      button.addEventListener("click", () => this.ask(name, action));
      return button;
    });
    this.list.append(element("span", "", name), state, kill, restart);
    const row = { state, kill, restart };
    this.rows.set(name, row);
    return row;
  }

  /** @param {string} name
   * @param {string} action */
  async ask(name, action) {
    const answer = await request("POST", `/api/processes/${encodeURIComponent(name)}/${action}`);
    setText(this.answer, answer.ok ? `${action} of ${name}: done` : answer.reason);
  }
}
