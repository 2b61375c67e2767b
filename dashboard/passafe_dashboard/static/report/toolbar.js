// Time, play, zoom: the controls that stay in sight.

import { timeText } from "./number_text.js";

const SLIDER_STEPS = 10_000;
const PLAY_S = 15;

export class Toolbar {
  /** @param {HTMLElement} element
   * @param {import("./time_view.js").TimeView} view */
  constructor(element, view) {
    this.view = view;
    const part = (name) => element.querySelector(`[data-part="${name}"]`);
    [this.slider, this.time, this.play, this.stretch] = ["slider", "time", "play", "stretch"].map(part);
    this.slider.max = String(SLIDER_STEPS);
    this.slider.addEventListener("input", () => this.slide());
    this.play.addEventListener("click", () => this.toggle());
    const actions = { in: () => view.zoom(0.5), out: () => view.zoom(2), all: () => view.showAll() };
    for (const [name, action] of Object.entries(actions)) part(name).addEventListener("click", action);
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

  press(event) {
    const { view } = this;
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.("select, textarea")) return;
    const step = (view.to - view.from) / 200;
    const actions = {
      "+": () => view.zoom(0.5),
      "-": () => view.zoom(2),
      0: () => view.showAll(),
      "[": () => view.pan(-0.5),
      "]": () => view.pan(0.5),
      ",": () => view.moveCursor(view.cursor - step),
      ".": () => view.moveCursor(view.cursor + step),
    };
    const action = actions[event.key];
    if (!action) return;
    action();
    if (",.".includes(event.key)) this.follow();
    event.preventDefault();
  }

  toggle() {
    this.playing = !this.playing;
    this.play.setAttribute("aria-pressed", String(this.playing));
    this.play.textContent = this.playing ? "Pause" : "Play";
    if (!this.playing) return;
    if (this.view.cursor >= this.view.to) this.view.moveCursor(this.view.from);
    this.last = performance.now();
    requestAnimationFrame((now) => this.advance(now));
  }

  /** Plays at the speed of the run, or what is in view in `PLAY_S` seconds if that is faster. */
  advance(now) {
    if (!this.playing) return;
    const { view } = this;
    const speed = Math.max(1, (view.to - view.from) / PLAY_S);
    view.moveCursor(view.cursor + ((now - this.last) / 1000) * speed);
    this.last = now;
    if (view.cursor >= view.to) this.toggle();
    else requestAnimationFrame((later) => this.advance(later));
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
