// Steering: joysticks, keys and gamepad of this page, the clutch, and when the controls are given back.

import { byId, setAttribute, setText } from "./elements.js";
import { afterClearText, driverText } from "./driver_panel.js";
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
const WATCH_MS = 50; // between looks at the gamepad of a page that does not drive
const PATIENCE_MS = 600;
const OTHERS_KEYS = ["Control", "Alt", "Meta"]; // keys of the browser or of the desktop
const HINT = "Drag the stick, or hold the arrow keys. Gamepad: hold R1.";

export class Steering {
  /** @param {{stop: () => void, afterwards: string}} stopButton */
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
    this.holdLost = false;
    /** @type {number | null} */
    this.heldSince = null;
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
    const name = (/** @type {number} */ i) => (pairs.length > 1 ? `Stick ${i + 1}` : "Stick");
    this.pads = pairs.map((axes, i) => new Pad(i, name(i), axes, size, { press: () => this.grip(), change: () => this.send() }));
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
      this.letGo();
      this.setClutch("key", false); // its key up goes elsewhere
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
    if (OTHERS_KEYS.includes(event.key)) this.keys.releaseAll(); // what was held may come up without a word
    if (!down) this.keys.set(event.code, false);
    if (!SteeringKeys.steers(event.code) || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = /** @type {HTMLElement} */ (event.target);
    if (down && target.closest?.("input, select, textarea, [role=tab]")) return;
    if (down && !this.grip()) return;
    if (down && !event.repeat) this.keys.set(event.code, true); // a key that was lost while held is pressed anew
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
    if (!this.you && now - this.steppedAt < WATCH_MS) return;
    if (this.you && this.engaged && now - this.steppedAt > STALL_MS) this.loseHold();
    const dt_s = Math.min((now - this.steppedAt) / 1000, 0.1);
    this.steppedAt = now;
    this.keys.step(dt_s, this.isClutched);
    this.readGamepad();
    this.send();
  }

  /** Returns whether the page may be steered from, and says so if not. */
  grip() {
    if (!this.you) this.say("Take the controls first.");
    return this.you;
  }

  letGo() {
    this.keys.releaseAll();
    for (const pad of this.pads) pad.stick.release();
  }

  /** Lets go where the robot is no longer driven although the hands hold on. */
  loseHold() {
    this.holdLost = true;
    this.letGo();
  }

  /** Notices a hold that the filter counts as released: it came too late, or its way to the operator was cut.
   * @param {import("./types.js").Now} now */
  watchHold(now) {
    const at = performance.now();
    this.heldSince = this.you && this.engaged ? this.heldSince ?? at : null;
    if (this.heldSince === null) return;
    const way_ms = now.ages?.command_ms ?? 0;
    const counted = now.filter?.command_state !== "released";
    if (counted) this.holdLost = false;
    else if (at - this.heldSince > PATIENCE_MS + 2 * way_ms) this.loseHold();
  }

  readGamepad() {
    const reading = this.gamepad.read(navigator.getGamepads?.() ?? [], Math.max(this.pads.length, 1));
    this.setClutch("pad", reading.clutched);
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
    setAttribute(take, "aria-pressed", String(this.you));
    setAttribute(byId("pads"), "data-idle", String(!this.you));
    const script = byId("script");
    const hidden = this.you || this.driver !== null;
    if (script.hidden !== hidden) script.hidden = hidden;
  }

  /** @param {string} text */
  say(text) {
    setText(document.getElementById("drive-hint"), text);
  }

  /** @param {import("./types.js").Now} now
   * @param {any} theme */
  draw(now, theme) {
    if (now.drive && !this.you) this.driver = now.drive.driver;
    this.watchHold(now);
    this.showDriver();
    this.stopButton.afterwards = afterClearText(this.driver ?? undefined, this.you, this.script);
    /** @type {HTMLButtonElement} */ (byId("take")).disabled = now.liveness.state === "ended" || now.session?.state === "stopped";
    const full = this.setup?.full ?? [];
    this.pads.forEach((pad, i) => pad.draw(now, full[pad.axes[0]] ?? 1, this.values[i] ?? [0, 0], theme));
    this.feel?.show(heldShare(now.filter), this.you);
  }
}
