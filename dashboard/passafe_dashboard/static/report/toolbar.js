// Time, play, zoom: the controls that stay in sight.

import { timeText } from "./number_text.js";

const SLIDER_STEPS = 10_000;
const PLAY_S = 15;

/** @typedef {HTMLElement & {value?: string}} Part */

export class Toolbar {
  /** @param {HTMLElement} element
   * @param {import("./time_view.js").TimeView} view */
  constructor(element, view) {
    this.view = view;
    /** @type {(name: string) => Part | null} */
    const found = (name) => element.querySelector(`[data-part="${name}"]`);
    const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (found(name));
    this.slider = /** @type {HTMLInputElement} */ (part("slider"));
    this.time = part("time");
    this.play = part("play");
    this.stretch = part("stretch");
    this.playing = false;
    this.last = 0;
    this.slider.max = String(SLIDER_STEPS);
    this.slider.addEventListener("input", () => this.slide());
    this.play.addEventListener("click", () => this.toggle());
    const actions = { in: () => view.zoom(0.5), out: () => view.zoom(2), all: () => view.showAll() };
    for (const [name, action] of Object.entries(actions)) part(name).addEventListener("click", action);
    this.speed = found("speed");
    this.parts = found;
    found("previous")?.addEventListener("click", () => this.toEvent(-1));
    found("next")?.addEventListener("click", () => this.toEvent(1));
    document.addEventListener("keydown", (event) => this.press(event));
    this.read();
  }

  slide() {
    const { view } = this;
    view.moveCursor(view.start + (Number(this.slider.value) / SLIDER_STEPS) * (view.end - view.start));
    this.follow();
  }

  /** Keeps the cursor in view. */
  follow() {
    const { view } = this;
    const span = view.to - view.from;
    if (view.cursor < view.from || view.cursor > view.to) view.show(view.cursor - span / 2, view.cursor + span / 2);
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const { view } = this;
    const target = /** @type {Element | null} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || target?.closest?.("select, textarea, input:not([type=range])")) return;
    const step = (view.to - view.from) / 200;
    /** @type {Record<string, () => void>} */
    const actions = {
      "+": () => view.zoom(0.5),
      "-": () => view.zoom(2),
      0: () => view.showAll(),
      "[": () => view.pan(-0.5),
      "]": () => view.pan(0.5),
      ",": () => view.moveCursor(view.cursor - step),
      ".": () => view.moveCursor(view.cursor + step),
      n: () => this.toEvent(1),
      p: () => this.toEvent(-1),
      w: () => this.parts("worst")?.click(),
      k: () => this.toggle(),
    };
    const action = actions[event.key];
    if (!action) return;
    action();
    if (",.".includes(event.key)) this.follow();
    event.preventDefault();
  }

  /** Goes to the nearest event or place to look at, in one direction of time.
   * @param {1 | -1} way */
  toEvent(way) {
    const { view } = this;
    /** @type {HTMLElement[]} */
    const buttons = [...document.querySelectorAll(/** @type {"button"} */ ("[data-jump]:not([data-part])"))];
    const apart = (/** @type {HTMLElement} */ button) => way * (Number(button.dataset.jump) - view.cursor);
    const ahead = buttons.filter((button) => apart(button) > 1e-6);
    /** @type {HTMLElement | null} */
    let nearest = null;
    for (const button of ahead) if (!nearest || apart(button) < apart(nearest)) nearest = button;
    nearest?.click();
    nearest?.scrollIntoView({ block: "nearest" });
  }

  toggle() {
    this.playing = !this.playing;
    this.play.setAttribute("aria-pressed", String(this.playing));
    this.play.textContent = this.playing ? "Pause" : "Play";
    if (!this.playing) return;
    if (this.view.cursor >= this.view.end) this.view.moveCursor(this.view.start);
    this.follow();
    this.last = performance.now();
    requestAnimationFrame((now) => this.advance(now));
  }

  /** Plays at the speed that is chosen; fitting is that of the run, or what is in view in `PLAY_S` seconds if faster.
   * @param {number} now */
  advance(now) {
    if (!this.playing) return;
    const { view } = this;
    const speed = Number(this.speed?.value) || Math.max(1, (view.to - view.from) / PLAY_S);
    view.moveCursor(view.cursor + ((now - this.last) / 1000) * speed);
    this.last = now;
    if (view.cursor >= view.end) this.toggle();
    else if (view.cursor >= view.to) view.show(view.cursor, view.cursor + view.to - view.from);
    if (!this.playing) return;
    requestAnimationFrame((later) => this.advance(later));
  }

  read() {
    const { view } = this;
    this.slider.value = String(Math.round(((view.cursor - view.start) / (view.end - view.start)) * SLIDER_STEPS));
    this.time.textContent = `${timeText(view.cursor)} s`;
    this.slider.setAttribute("aria-valuetext", `${timeText(view.cursor)} seconds of plant time`);
    const step = (view.to - view.from) / 100;
    this.stretch.textContent = `${timeText(view.from, step)} to ${timeText(view.to, step)} s`;
  }
}
