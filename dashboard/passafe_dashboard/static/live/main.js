// The live page: frames in, two sheets out. What arrives is drawn in the next animation frame, so a hidden page does no
// work and catches up when it is shown. When another scenario is announced, the sheets are built anew in place.

import { onThemeChange } from "../report/theme.js";
import { StopButton } from "../stop_button.js";
import { connect } from "./connection.js";
import { DriveSheet } from "./drive_sheet.js";
import { byId, setAttribute, setText } from "./elements.js";
import { EngineerSheet } from "./engineer_sheet.js";
import { FrameQueue } from "./frame_queue.js";
import { MODES } from "./run_panel.js";
import { LiveTable } from "./live_table.js";
import { Steering } from "./steering.js";
import { readLiveTheme } from "./theme.js";

/** @typedef {import("./types.js").Setup} Setup */

const WORDS = { live: "live", waiting: "waiting", silent: "no messages", lost: "lost", ended: "run ended" };

class LivePage {
  constructor() {
    this.stopButton = new StopButton(document);
    this.steering = new Steering(this.stopButton);
    this.theme = readLiveTheme();
    this.drawn = 0;
    this.build(JSON.parse(byId("setup").textContent ?? "{}"));
    onThemeChange(() => {
      this.theme = readLiveTheme();
    });
    window.addEventListener("hashchange", () => this.chooseSheet());
  }

  /** @param {Setup} setup */
  build(setup) {
    this.setup = setup;
    this.queue = new FrameQueue(setup.rows);
    this.drive = null;
    this.engineer = null;
    if (setup.columns) {
      const tables = { ticks: new LiveTable(setup.columns.ticks, setup.rows), states: new LiveTable(setup.columns.states, setup.rows) };
      this.tables = tables;
      this.drive = new DriveSheet(setup, tables, this.steering);
      this.engineer = new EngineerSheet(setup, tables);
    }
    this.chooseSheet();
  }

  chooseSheet() {
    const chosen = location.hash === "#engineer" ? "engineer" : "drive";
    for (const link of document.querySelectorAll("[data-sheet]")) {
      if (/** @type {HTMLElement} */ (link).dataset.sheet === chosen) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    this.sheet = chosen;
    for (const name of ["drive", "engineer"]) document.getElementById(`${name}-sheet`)?.toggleAttribute("hidden", name !== chosen);
  }

  /** @param {import("./types.js").Frame} frame */
  receive(frame) {
    if (frame.layout !== this.setup?.layout) {
      this.adopt();
      return;
    }
    this.queue?.add(frame);
    this.showConnection(frame.now.liveness.state, frame.now.liveness.text);
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame((at) => this.draw(at));
  }

  /** Fetches the page of the scenario that is announced and builds its sheets here; the controls stay as they are. */
  async adopt() {
    if (this.adopting) return;
    this.adopting = true;
    try {
      const response = await fetch("/");
      const page = new DOMParser().parseFromString(await response.text(), "text/html");
      const setup = JSON.parse(page.getElementById("setup")?.textContent ?? "{}");
      document.title = page.title;
      for (const selector of ["main", ".what"]) document.querySelector(selector)?.replaceWith(/** @type {Node} */ (page.querySelector(selector)));
      this.build(setup);
      this.restart = true;
    } catch {
      // The server is going away; the connection says so, and the next frame tries again.
    } finally {
      this.adopting = false;
    }
  }

  /** @param {number} at */
  draw(at) {
    this.scheduled = false;
    const frame = this.queue?.take();
    if (!frame) return;
    const { tables } = this;
    if (tables) {
      if (frame.restart) {
        tables.ticks.clear();
        tables.states.clear();
        this.engineer?.forgetEvents();
      }
      tables.ticks.push(frame.tables.ticks);
      tables.states.push(frame.tables.states);
    }
    const { now } = frame;
    this.stopButton.show(now.stop);
    const mode = now.filter?.mode ?? now.scenario?.mode;
    setText(document.getElementById("mode"), MODES[/** @type {keyof typeof MODES} */ (mode)] ?? "–");
    setText(document.getElementById("plant-time"), now.plant ? `${now.plant.time_s.toFixed(1)} s` : "–");
    if (this.sheet === "drive") this.drive?.draw(now, this.theme, at);
    else this.engineer?.draw(now, this.theme, at, frame.lost);
    this.drawn += 1;
  }

  /** @param {string} state
   * @param {string} text */
  showConnection(state, text) {
    const connection = byId("connection");
    setAttribute(connection, "data-state", state);
    setText(connection, WORDS[/** @type {keyof typeof WORDS} */ (state)]);
    const banner = byId("banner");
    const hidden = state === "live" || (state !== "lost" && this.sheet === "drive" && Boolean(this.drive));
    if (banner.hidden !== hidden) banner.hidden = hidden;
    setAttribute(banner, "data-state", state);
    setText(banner, hidden ? "" : text);
  }
}

const page = new LivePage();
Object.assign(window, { passafePage: page });
connect({ onFrame: (frame) => page.receive(frame), onState: (state, text) => page.showConnection(state, text) });
