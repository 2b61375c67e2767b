// The drive sheet: scene, words, distances, energy, delays, driver, and what can be changed.

import { showDelays } from "./delays_panel.js";
import { showDriver } from "./driver_panel.js";
import { byId, setText } from "./elements.js";
import { EnergyMeter } from "./energy_meter.js";
import { GapBars } from "./gap_bars.js";
import { JointScene } from "./joint_scene.js";
import { NetworkPanel } from "./network_panel.js";
import { PlaneScene } from "./plane_scene.js";
import { ProcessPanel } from "./process_panel.js";
import { RunPanel } from "./run_panel.js";
import { SpaceScene } from "./space_scene.js";
import { connectTabs } from "./tabs.js";
import { HOLD_LOST, showWords } from "./words_panel.js";

/** @typedef {import("./types.js").Now} Now */

const NUMBERS_EVERY_MS = 200;
const PANELS_EVERY_MS = 250;

/** Returns the scene of a robot in space, of joints, or in the plane.
 * @param {import("./types.js").Setup["scene"]} scene
 * @param {HTMLCanvasElement} ground
 * @param {HTMLCanvasElement} canvas
 * @param {import("./live_table.js").LiveTable} states
 * @param {number[]} full */
function sceneOf(scene, ground, canvas, states, full) {
  if (scene?.kind === "space") return new SpaceScene(ground, canvas, scene);
  if (scene?.kind === "joints") return new JointScene(ground, canvas, scene, full);
  return new PlaneScene(ground, canvas, /** @type {import("./types.js").Plane} */ (scene), states, full);
}

export class DriveSheet {
  /** @param {import("./types.js").Setup} setup
   * @param {{ticks: import("./live_table.js").LiveTable, states: import("./live_table.js").LiveTable}} tables
   * @param {import("./steering.js").Steering} steering */
  constructor(setup, tables, steering) {
    this.setup = setup;
    this.steering = steering;
    const [ground, canvas] = ["scene-ground", "scene"].map((id) => /** @type {HTMLCanvasElement} */ (byId(id)));
    const full = setup.drive?.full ?? [];
    this.scene = sceneOf(setup.scene, ground, canvas, tables.states, full);
    this.gaps = new GapBars();
    this.energy = new EnergyMeter();
    this.network = new NetworkPanel(setup);
    this.run = new RunPanel();
    this.processes = new ProcessPanel();
    connectTabs(/** @type {HTMLElement} */ (document.querySelector(".tabs")));
    steering.build(setup);
    this.tone = "";
    this.numbersAt = -Infinity;
    this.panelsAt = -Infinity;
  }

  /** @param {Now} now
   * @param {import("./theme.js").LiveTheme} theme
   * @param {number} at */
  draw(now, theme, at) {
    this.scene.draw(now, theme);
    this.steering.draw(now, theme);
    // Words and numbers of one state, at a rate that can be read; a change of tone is shown at once.
    if (at - this.numbersAt >= NUMBERS_EVERY_MS || now.words.tone !== this.tone || now.liveness.state === "ended") {
      this.numbersAt = at;
      this.tone = now.words.tone;
      this.showNumbers(now);
    }
    if (at - this.panelsAt >= PANELS_EVERY_MS) {
      this.panelsAt = at;
      this.network.show(now.link_states);
      this.run.show(now.session);
      this.processes.show(now);
    }
  }

  /** @param {Now} now */
  showNumbers(now) {
    showWords(this.steering.holdLost && now.liveness.state === "live" && now.words.tone === "free" ? HOLD_LOST : now.words);
    this.gaps.show(now.gaps);
    this.energy.show(now.energy, this.setup.tolerances.power_margin_w);
    showDelays(now.liveness.state === "live" && !now.stop.id ? now.ages : undefined);
    showDriver(now, this.steering.you, this.setup.script);
    const age = byId("scene-age");
    age.hidden = now.liveness.state === "live";
    if (!age.hidden) setText(age, now.liveness.text);
  }
}
