// One chart over time: heading, legend with the values at the cursor, plot; dragging zooms, moving moves the cursor.

import { LinearAxis, SignedLogAxis, multiples, roundStep } from "./axis.js";
import { eachStretch, haloText } from "./band_plot.js";
import { Legend } from "./legend.js";
import { drawStroke, extent } from "./line_plot.js";
import { timeText } from "./number_text.js";
import { lineDash, LINES, readTheme } from "./theme.js";

const LEFT = 62;
const RIGHT = 10;
const TOP = 8;
const BOTTOM = 22;
const ROW = 22;
const LINES_HEIGHT = 170;
const LEAST_DRAG = 5;
const SECOND_RUN = 0.5;

/** @typedef {import("./payload.js").DrawnRun} Run */

/** @typedef {CanvasRenderingContext2D} Pen */

export class ChartPanel {
  /** @param {import("./payload.js").ChartPlan} plan
   * @param {Run[]} runs unpacked runs
   * @param {import("./time_view.js").TimeView} view
   * @param {import("./payload.js").Bands} bands colours and names of statuses and phases
   * @param {string} description for readers who cannot see it */
  constructor(plan, runs, view, bands, description) {
    this.plan = plan;
    this.runs = runs;
    this.view = view;
    this.bands = bands;
    this.theme = readTheme();
    /** @type {import("./line_plot.js").Box} */
    this.box = { left: LEFT, top: TOP, width: 1, height: 1 };
    this.legend = new Legend(plan, () => this.draw());
    this.element = document.createElement("section");
    this.plot = Object.assign(document.createElement("div"), { className: "plot" });
    this.canvas = document.createElement("canvas");
    this.cursor = Object.assign(document.createElement("div"), { className: "cursor" });
    this.selection = Object.assign(document.createElement("div"), { className: "selection", hidden: true });
    this.build(description);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  /** @param {string} description */
  build(description) {
    const { plan } = this;
    this.element.className = "panel";
    this.element.id = `chart-${plan.key}`;
    const heading = document.createElement("h3");
    heading.textContent = plan.title;
    if (plan.unit) heading.append(Object.assign(document.createElement("small"), { textContent: ` ${plan.unit}` }));
    const note = Object.assign(document.createElement("p"), { className: "note", textContent: plan.note });
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", description);
    this.plot.append(this.canvas, this.cursor, this.selection);
    this.element.append(heading, this.legend.element, this.plot);
    if (plan.note) this.element.append(note);
    this.listen();
  }

  listen() {
    /** @type {{x: number, drags: boolean} | null} */
    let pressed = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      pressed = { x: event.offsetX, drags: event.pointerType === "mouse" };
      this.canvas.setPointerCapture(event.pointerId);
      this.view.moveCursor(this.timeAt(event.offsetX));
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!pressed?.drags) this.view.moveCursor(this.timeAt(event.offsetX));
      else this.select(pressed.x, event.offsetX);
    });
    this.canvas.addEventListener("pointerup", (event) => {
      if (pressed?.drags && Math.abs(event.offsetX - pressed.x) >= LEAST_DRAG) {
        const times = [this.timeAt(pressed.x), this.timeAt(event.offsetX)].sort((a, b) => a - b);
        this.view.show(times[0], times[1]);
      }
      pressed = null;
      this.selection.hidden = true;
    });
    this.canvas.addEventListener("pointercancel", () => {
      pressed = null;
      this.selection.hidden = true;
    });
    this.canvas.addEventListener("dblclick", () => this.view.showAll());
    this.canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.view.zoom(event.deltaY > 0 ? 1.25 : 0.8, this.timeAt(event.offsetX));
    });
  }

  /** @param {number} from
   * @param {number} to */
  select(from, to) {
    this.selection.hidden = Math.abs(to - from) < LEAST_DRAG;
    this.selection.style.left = `${Math.min(from, to)}px`;
    this.selection.style.width = `${Math.abs(to - from)}px`;
  }

  /** @param {number} x */
  timeAt(x) {
    return this.view.from + ((x - LEFT) / this.box.width) * (this.view.to - this.view.from);
  }

  /** Returns the lines that are drawn, one for each run that has the signal. */
  get drawn() {
    const lines = this.legend.shown.flatMap((line) => this.runs.map((run, number) => ({ line, run, number })));
    return lines.filter(({ line, run }) => run.tables[line.table].has(line.column));
  }

  draw() {
    const width = this.plot.clientWidth;
    const rows = this.plan.kind === "lines" ? 0 : Math.max(this.drawn.length, 1);
    const height = rows ? rows * ROW + TOP + BOTTOM : LINES_HEIGHT;
    this.box = { left: LEFT, top: TOP, width: Math.max(width - LEFT - RIGHT, 1), height: height - TOP - BOTTOM };
    const ratio = window.devicePixelRatio || 1;
    const size = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) [this.canvas.width, this.canvas.height] = size;
    this.canvas.style.height = `${height}px`;
    const pen = /** @type {Pen} */ (this.canvas.getContext("2d"));
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = "11px system-ui, sans-serif";
    this.drawTimes(pen);
    if (this.plan.kind === "lines") this.drawLines(pen);
    else this.drawBands(pen);
    this.readCursor();
  }

  /** @param {Pen} pen */
  drawTimes(pen) {
    const { box, view, theme } = this;
    const step = roundStep(view.to - view.from, box.width / 90);
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const time of multiples(view.from, view.to, step)) {
      const x = Math.round(box.left + ((time - view.from) / (view.to - view.from)) * box.width) + 0.5;
      pen.strokeStyle = theme.grid;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(x, box.top);
      pen.lineTo(x, box.top + box.height);
      pen.stroke();
      pen.fillStyle = theme.quiet;
      const text = timeText(time, step);
      const half = pen.measureText(text).width / 2;
      pen.fillText(text, Math.min(x, box.left + box.width + RIGHT - half), box.top + box.height + 6);
    }
  }

  /** @param {Pen} pen */
  drawLines(pen) {
    const { box, view, theme, plan } = this;
    const strokes = this.drawn.map(({ line, run, number }) => {
      return {
        table: run.tables[line.table],
        column: line.column,
        colour: theme.lines[line.style % LINES],
        dash: number ? [2, 2] : lineDash(plan, line),
        width: number ? 2.2 : 1.6,
        alpha: number ? SECOND_RUN : 1,
      };
    });
    const [low, high] = extent(strokes, view);
    const axis = plan.linear ? new SignedLogAxis(low, high, plan) : new LinearAxis(low, high, plan);
    this.drawValues(pen, axis);
    pen.save();
    pen.beginPath();
    pen.rect(box.left, box.top - 2, box.width, box.height + 4);
    pen.clip();
    for (const stroke of strokes.reverse()) drawStroke(pen, box, view, axis, stroke);
    pen.restore();
  }

  /** @param {Pen} pen
   * @param {LinearAxis | SignedLogAxis} axis */
  drawValues(pen, axis) {
    const { box, theme, plan } = this;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const [value, text] of axis.ticks(5)) {
      const y = Math.round(box.top + box.height * (1 - axis.share(value))) + 0.5;
      const limit = plan.zero && value === 0;
      pen.strokeStyle = limit ? theme.ink : theme.grid;
      pen.lineWidth = limit ? 1.2 : 1;
      pen.beginPath();
      pen.moveTo(box.left, y);
      pen.lineTo(box.left + box.width, y);
      pen.stroke();
      pen.fillStyle = theme.quiet;
      pen.fillText(text, box.left - 6, y);
    }
  }

  /** @param {Pen} pen */
  drawBands(pen) {
    const { box, view, theme, plan } = this;
    this.drawn.forEach(({ line, run, number }, row) => {
      const top = box.top + row * ROW + 2;
      const styles = this.bands[line.column];
      eachStretch(run.tables[line.table], line.column, box, view, (left, width, low, high) => {
        pen.globalAlpha = styles || low > 0 ? 1 : 0.45;
        pen.fillStyle = styles ? (styles[high]?.colour ?? theme.quiet) : theme.lines[0];
        if (styles || high > 0) pen.fillRect(left, top, width, ROW - 4);
        pen.globalAlpha = 1;
      });
      const name = this.runs.length > 1 ? `${line.label}, ${this.runs[number].label}` : line.label;
      if (plan.kind === "rows" || this.runs.length > 1) haloText(pen, name, box.left + 4, top + ROW / 2 - 2, theme);
      else {
        pen.textAlign = "right";
        pen.textBaseline = "middle";
        pen.fillStyle = theme.quiet;
        pen.fillText(name, box.left - 6, top + ROW / 2 - 2);
      }
    });
  }

  readCursor() {
    const { view, box } = this;
    const share = (view.cursor - view.from) / (view.to - view.from);
    this.cursor.hidden = share < 0 || share > 1;
    this.cursor.style.transform = `translateX(${box.left + share * box.width}px)`;
    this.legend.read(this.runs, view.cursor, this.bands);
  }
}
