// Steering: joysticks, keys and gamepad of this page, the clutch, and when the controls are given back.

import { byId, setText } from "./elements.js";
import { driverText } from "./driver_panel.js";
import { DriveSocket } from "./drive_socket.js";
import { Feel, heldShare } from "./feel.js";
import { GamepadReader } from "./gamepad.js";
import { SteeringKeys } from "./keys.js";
import { Pad } from "./pad.js";
import { axisShares, firstEngaged } from "./shares.js";

/** @typedef {import("./types.js").DriveSetup} DriveSetup
 * @typedef {import("./types.js").Pair} Pair */

const PERIOD_MS = 16;
const STALL_MS = 250; // then the operator counts the command no more, until the dead-man was let go
const HINT = "Drag the stick, or hold the arrow keys. Gamepad: hold R1.";

export class Steering {
  /** @param {{stop: () => void}} stopButton */
  constructor(stopButton) {
    this.stopButton = stopButton;
    this.gamepad = new GamepadReader();
    this.keys = new SteeringKeys(1);
    /** @type {Pad[]} */
    this.pads = [];
    /** @type {DriveSetup | null} */
    this.setup = null;
    this.clutched = { key: false, button: false, pad: false };
    this.driver = /** @type {import("./types.js").Driver} */ (null);
    /** @type {Pair[]} */
    this.values = [];
    this.steppedAt = performance.now();
    this.socket = new DriveSocket({
      onDriver: (news) => this.showNews(news),
      onRefused: (text) => this.say(text),
    });
    this.listen();
    setInterval(() => this.step(), PERIOD_MS);
  }

  get you() {
    return this.socket.you;
  }

  /** Builds the controls of a scenario into the page.
   * @param {import("./types.js").Setup} page */
  build({ drive, script }) {
    this.setup = drive ?? null;
    if (drive) this.socket.open();
    this.script = script;
    const pairs = drive?.pairs ?? [];
    const size = pairs.length > 1 ? 104 : 150;
    this.pads = pairs.map((axes, i) => new Pad(i, pairs.length > 1 ? `Stick ${i + 1}` : "Stick", axes, size, () => this.send()));
    this.keys = new SteeringKeys(Math.max(pairs.length, 1));
    byId("pads").replaceChildren(...this.pads.map(({ canvas }) => canvas));
    byId("take").addEventListener("click", () => this.toggle());
    byId("script").addEventListener("click", () => this.socket.script());
    const clutch = byId("clutch");
    clutch.addEventListener("click", () => this.setClutch("button", !this.clutched.button));
    this.feel = new Feel(/** @type {HTMLInputElement} */ (byId("feel")));
    this.showDriver();
  }

  listen() {
    document.addEventListener("keydown", (event) => this.key(event, true));
    document.addEventListener("keyup", (event) => this.key(event, false));
    const leave = () => {
      this.keys.releaseAll();
      for (const pad of this.pads) pad.stick.release();
      this.socket.release();
    };
    window.addEventListener("blur", leave);
    window.addEventListener("pagehide", leave);
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) leave();
    });
  }

  /** @param {KeyboardEvent} event
   * @param {boolean} down */
  key(event, down) {
    if (event.key === "Shift") this.setClutch("key", down);
    if (!SteeringKeys.steers(event.code) || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = /** @type {HTMLElement} */ (event.target);
    if (down && target.closest?.("input, select, textarea, [role=tab]")) return;
    if (!this.you && down) return;
    this.keys.set(event.code, down);
    event.preventDefault();
  }

  /** @param {"key" | "button" | "pad"} source
   * @param {boolean} on */
  setClutch(source, on) {
    if (this.clutched[source] === on) return;
    this.clutched[source] = on;
    for (const pad of this.pads) pad.stick.clutch(this.isClutched);
    document.getElementById("clutch")?.setAttribute("aria-pressed", String(this.isClutched));
  }

  get isClutched() {
    return this.clutched.key || this.clutched.button || this.clutched.pad;
  }

  toggle() {
    if (this.you) this.socket.release();
    else this.socket.take(this.driver !== null);
  }

  /** Reads the hands and sends what they ask for. */
  step() {
    const now = performance.now();
    if (this.you && this.engaged && now - this.steppedAt > STALL_MS) this.say("This page stalled: let go once, then drive on.");
    const dt_s = Math.min((now - this.steppedAt) / 1000, 0.1);
    this.steppedAt = now;
    this.keys.step(dt_s, this.isClutched);
    this.readGamepad();
    this.send();
  }

  readGamepad() {
    const reading = this.gamepad.read(navigator.getGamepads?.() ?? [], Math.max(this.pads.length, 1));
    if (reading.connected) this.setClutch("pad", reading.clutched);
    if (reading.stop) this.stopButton.stop();
    if (reading.take && !this.you) this.toggle();
    if (this.isClutched && this.held?.engaged && reading.engaged) return;
    this.held = { engaged: reading.engaged, values: reading.values };
  }

  send() {
    const { setup } = this;
    if (!setup) return;
    const engagedPad = this.pads.some(({ stick }) => stick.engaged);
    const padSource = { engaged: engagedPad, values: this.pads.map(({ stick }) => stick.value) };
    const keySource = { engaged: this.keys.engaged, values: this.keys.values };
    const chosen = firstEngaged([padSource, this.held ?? keySource, keySource], this.pads.length);
    this.values = chosen.values;
    this.engaged = chosen.engaged;
    if (this.you) this.socket.steer(axisShares(chosen.values, setup.pairs, setup.axes), chosen.engaged);
  }

  /** @param {import("./drive_socket.js").DriverNews} news */
  showNews(news) {
    const lost = this.wasYou && !news.you;
    this.wasYou = news.you;
    this.driver = news.driver;
    this.showDriver();
    if (news.reason && (lost || !news.you)) this.say(lost ? `The controls are gone: ${news.reason}.` : `${news.reason}.`);
    else if (news.you) this.say(HINT);
  }

  showDriver() {
    const take = document.getElementById("take");
    if (!take) return;
    const other = this.driver && (this.driver.page || this.driver.device !== this.script);
    const words = other ? `Take over from ${driverText(this.driver, false, this.script)}` : "Take the controls";
    setText(take, this.you ? "Give back the controls" : words);
    take.setAttribute("aria-pressed", String(this.you));
    byId("pads").dataset.idle = String(!this.you);
    byId("script").hidden = this.you || this.driver !== null;
  }

  /** @param {string} text */
  say(text) {
    setText(document.getElementById("drive-hint"), text);
  }

  /** @param {import("./types.js").Now} now
   * @param {any} theme */
  draw(now, theme) {
    if (now.drive && !this.you) this.driver = now.drive.driver;
    this.showDriver();
    const full = this.setup?.full ?? [];
    this.pads.forEach((pad, i) => pad.draw(now, full[pad.axes[0]] ?? 1, this.values[i] ?? [0, 0], theme));
    this.feel?.show(heldShare(now.filter), this.you);
  }
}
