// The run: scenario, mode, prediction and recording of the next one; start and end; what the last one was judged.

import { byId, element, setText } from "./elements.js";
import { request } from "./requests.js";

/** @typedef {import("./types.js").Session} Session */

export const MODES = { off: "filter off", safe: "safe", passive: "passive", both: "safe and passive" };

/** Returns the last run's verdict in a sentence.
 * @param {Session["last"]} last */
export function lastText(last) {
  if (!last) return "";
  return `Run ${last.run}: ${last.words || (last.log ? "its log is being judged" : last.detail)}`;
}

export class RunPanel {
  constructor() {
    this.panel = byId("panel-run");
    this.answer = byId("panel-answer");
    this.touched = false;
    this.form = document.createElement("form");
    this.form.className = "run-form";
    this.scenario = document.createElement("select");
    this.scenario.name = "scenario";
    this.prediction = checkbox("prediction");
    this.gatekeeper = checkbox("gatekeeper");
    this.recording = checkbox("recording");
    for (const [box, text] of this.titles()) box.label.title = text;
    this.go = button("Start", "submit");
    this.end = button("End the run", "button");
    this.note = element("p", "run-note");
    this.last = element("p", "run-note");
    const label = element("label", "", "Scenario ");
    label.append(this.scenario);
    this.form.append(label, modeChoices(), this.prediction.label, this.gatekeeper.label, this.recording.label, this.go, this.end, this.note, this.last);
    this.panel.replaceChildren(this.form);
    this.listen();
  }

  /** @returns {[{label: HTMLLabelElement}, string][]} */
  titles() {
    return [
      [this.prediction, "Decide for the state in which the input will take effect, not for the newest one received"],
      [this.gatekeeper, "Send an input only if the robot's own braking is proven to keep every limit from where it leads"],
      [this.recording, "Write a log of the next run, which is judged when it ends"],
    ];
  }

  listen() {
    this.end.addEventListener("click", () => this.stop());
    this.form.addEventListener("input", () => {
      this.touched = true;
    });
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.start();
    });
  }

  async start() {
    const chosen = new FormData(this.form);
    const body = {
      scenario: chosen.get("scenario"),
      mode: chosen.get("mode"),
      prediction: this.prediction.box.checked,
      gatekeeper: this.gatekeeper.box.checked,
      recording: this.recording.box.checked,
    };
    setText(this.answer, "starting …");
    const answer = await request("POST", "/api/run", body);
    setText(this.answer, answer.ok ? "" : answer.reason);
    this.touched = false;
  }

  async stop() {
    setText(this.answer, "ending …");
    const answer = await request("DELETE", "/api/run");
    setText(this.answer, answer.ok ? "" : answer.reason);
  }

  /** @param {Session | null | undefined} session */
  show(session) {
    const may = Boolean(session?.can.includes("run"));
    for (const control of this.form.elements) /** @type {HTMLInputElement} */ (control).disabled = !may;
    if (!session) {
      setText(this.note, "This system was not started by a demo: runs are started where its processes are.");
      return;
    }
    this.offer(session);
    const running = session.state === "running" || session.state === "starting";
    setText(this.go, running ? "Start a new run" : "Start");
    this.end.disabled = !may || !running;
    const words = running ? `Run ${session.run} is ${session.state}. A new one ends it: its log is closed and judged.` : `Run ${session.run} is ${session.state}.`;
    setText(this.note, session.trouble || words);
    this.showLast(session.last);
  }

  /** @param {Session} session */
  offer(session) {
    const box = this.scenario;
    if (box.options.length !== session.scenarios.length) box.replaceChildren(...session.scenarios.map((name) => new Option(name, name)));
    if (this.touched) return;
    box.value = session.scenario;
    for (const radio of this.form.querySelectorAll("input[name=mode]")) {
      /** @type {HTMLInputElement} */ (radio).checked = /** @type {HTMLInputElement} */ (radio).value === session.mode;
    }
    this.prediction.box.checked = session.prediction;
    this.gatekeeper.box.checked = session.gatekeeper;
    this.recording.box.checked = session.log !== null; // also while none is written: it is the choice for the next run
  }

  /** @param {Session["last"]} last */
  showLast(last) {
    const text = lastText(last);
    if (this.last.dataset.text === text) return;
    this.last.dataset.text = text;
    this.last.replaceChildren(text);
    if (!last?.log) return;
    const link = document.createElement("a");
    link.href = `/logs/${encodeURIComponent(last.log)}#worst`;
    link.textContent = "see its worst moment";
    this.last.append(" – ", link);
  }
}

/** @param {string} name */
function checkbox(name) {
  const label = document.createElement("label");
  const box = document.createElement("input");
  Object.assign(box, { type: "checkbox", name });
  label.append(box, ` ${name}`);
  return { label, box };
}

/** @param {string} text
 * @param {"submit" | "button"} type */
function button(text, type) {
  const made = document.createElement("button");
  Object.assign(made, { type, className: type === "submit" ? "main-button" : "", textContent: text });
  return made;
}

function modeChoices() {
  const modes = element("fieldset");
  modes.append(element("legend", "", "Filter"));
  for (const [mode, words] of Object.entries(MODES)) {
    const choice = element("label");
    const radio = document.createElement("input");
    Object.assign(radio, { type: "radio", name: "mode", value: mode });
    choice.append(radio, ` ${words}`);
    modes.append(choice);
  }
  return modes;
}
