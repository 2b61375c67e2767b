// The scene at the cursor: robot, trail, obstacles and walls in the plane.

import { multiples, roundStep, tickText } from "./axis.js";
import { line, prepare } from "./drawing.js";

const MARGIN = 30;
const ARROW_PX = 60;
const LEAST_STEP = 1e-3;

/** Returns the places of a point of the robot over the run, without those where it hardly moved.
 * @param {import("./signal_table.js").SignalTable} table
 * @param {number} point */
function trail(table, point) {
  const [x, y] = [0, 1].map((axis) => table.envelope(`q_${2 * point + axis}`).low);
  const least = LEAST_STEP * Math.max(reach(x), reach(y));
  const found = [];
  let last = null;
  for (let i = 0; i < x.length; i += 1) {
    if (Number.isNaN(x[i]) || (last && Math.hypot(x[i] - last.x, y[i] - last.y) < least)) continue;
    last = { time: table.start[i], x: x[i], y: y[i] };
    found.push(last);
  }
  return found;
}

/** Returns the difference between the highest and the lowest value.
 * @param {Float32Array} values */
function reach(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return high > low ? high - low : 0;
}

/** @typedef {import("./payload.js").Pair} Pair */

/** @typedef {import("./payload.js").Run} Run */

/** @typedef {import("./theme.js").Theme} Theme */

/** @typedef {CanvasRenderingContext2D} Pen */

/** @typedef {{time: number, x: number, y: number}} Step */

export class PlaneScene {
  /** @param {HTMLCanvasElement} canvas
   * @param {Run[]} runs
   * @param {import("./time_view.js").TimeView} view */
  constructor(canvas, runs, view) {
    this.canvas = canvas;
    this.runs = runs;
    this.view = view;
    this.scene = /** @type {import("./payload.js").PlanePicture} */ (runs[0].scene);
    /** @type {(x: number, y: number) => Pair} */
    this.place = (x, y) => [x, y];
    this.time = 0;
    this.trails = runs.map((run) => Array.from({ length: this.scene.points }, (_, point) => trail(run.tables.states, point)));
    this.bounds = this.findBounds();
    this.largest = this.largestInput();
  }

  /** Returns the rectangle that holds trails and bounded outlines, wherever they move. */
  findBounds() {
    /** @type {Pair[]} */
    const places = this.trails.flat(2).map(({ x, y }) => [x, y]);
    for (const outline of this.scene.outlines) {
      if (!outline.closed) continue;
      const moved = this.displacements(outline);
      const xs = outline.border.map(([x]) => x);
      const ys = outline.border.map(([, y]) => y);
      for (const [dx, dy] of moved) {
        places.push([Math.min(...xs) + dx, Math.min(...ys) + dy], [Math.max(...xs) + dx, Math.max(...ys) + dy]);
      }
    }
    if (!places.length) places.push([-1, -1], [1, 1]);
    const low = [0, 1].map((axis) => places.reduce((least, place) => Math.min(least, place[axis]), Infinity));
    const high = [0, 1].map((axis) => places.reduce((most, place) => Math.max(most, place[axis]), -Infinity));
    const span = Math.max(high[0] - low[0], high[1] - low[1], 0.1);
    return { low: low.map((value) => value - 0.05 * span), high: high.map((value) => value + 0.05 * span) };
  }

  /** Returns the places of an outline that moves, of which not all are needed.
   * @param {import("./payload.js").Outline} outline
   * @returns {Pair[]} */
  displacements(outline) {
    if (outline.moving === null) return [[0, 0]];
    const [dx, dy] = [0, 1].map((axis) => this.runs[0].tables.states.envelope(`d_${outline.moving}_${axis}`).low);
    const stride = Math.max(1, Math.floor(dx.length / 500));
    /** @type {Pair[]} */
    const found = [];
    const reach = this.reach();
    for (let i = 0; i < dx.length; i += stride) if (Math.hypot(dx[i], dy[i]) < reach) found.push([dx[i], dy[i]]);
    return found;
  }

  /** Returns how far an outline may move and still count for the view: one that leaves for good must not stretch it. */
  reach() {
    const places = this.trails.flat(2);
    return 3 * Math.max(...places.map(({ x, y }) => Math.hypot(x, y)), 1);
  }

  largestInput() {
    const { table, columns } = this.inputs(this.runs[0]);
    let most = 1e-9;
    for (const name of columns) for (const value of table.envelope(name).high) if (Math.abs(value) > most) most = Math.abs(value);
    return most;
  }

  /** @param {Run} run */
  inputs(run) {
    const columns = ["asked", "sent"].flatMap((kind) => [0, 1].map((axis) => `${kind}_${axis}`));
    return { table: run.tables.ticks, columns: columns.filter((name) => run.tables.ticks.has(name)) };
  }

  /** @param {Theme} theme */
  draw(theme) {
    const { canvas, bounds, view } = this;
    const width = canvas.clientWidth;
    const span = [0, 1].map((axis) => bounds.high[axis] - bounds.low[axis]);
    const room = width - 2 * MARGIN;
    const height = Math.round(Math.min(Math.max((room * span[1]) / span[0], 140), 420)) + 2 * MARGIN;
    const scale = Math.min(room / span[0], (height - 2 * MARGIN) / span[1]);
    const centre = [0, 1].map((axis) => (bounds.low[axis] + bounds.high[axis]) / 2);
    this.place = (x, y) => [width / 2 + (x - centre[0]) * scale, height / 2 - (y - centre[1]) * scale];
    const pen = prepare(canvas, width, height);
    this.drawGrid(pen, theme, width, height, scale, centre);
    for (const outline of this.scene.outlines) this.drawOutline(pen, outline, theme);
    this.runs.forEach((run, number) => this.drawRun(pen, run, number, theme));
    this.time = view.cursor;
  }

  /** @param {Pen} pen
   * @param {Theme} theme
   * @param {number} width
   * @param {number} height
   * @param {number} scale
   * @param {number[]} centre */
  drawGrid(pen, theme, width, height, scale, centre) {
    const step = roundStep(width / scale, 6);
    pen.font = "11px system-ui, sans-serif";
    pen.lineWidth = 1;
    const reach = [width, height].map((size, axis) => [centre[axis] - size / 2 / scale, centre[axis] + size / 2 / scale]);
    for (const x of multiples(reach[0][0], reach[0][1], step)) {
      line(pen, [this.place(x, reach[1][0]), this.place(x, reach[1][1])], theme.grid);
      pen.fillStyle = theme.quiet;
      pen.textAlign = "center";
      pen.fillText(tickText(x, step), this.place(x, 0)[0], height - 5);
    }
    for (const y of multiples(reach[1][0], reach[1][1], step)) {
      const [, row] = this.place(0, y);
      line(pen, [[0, row], [width, row]], theme.grid);
      pen.textAlign = "left";
      if (row < height - 22) pen.fillText(tickText(y, step), 3, row - 3);
    }
  }

  /** @param {Pen} pen
   * @param {import("./payload.js").Outline} outline
   * @param {Theme} theme */
  drawOutline(pen, outline, theme) {
    const states = this.runs[0].tables.states;
    const moved = [0, 1].map((axis) =>
      outline.moving === null ? 0 : (states.value(`d_${outline.moving}_${axis}`, this.view.cursor) ?? 0),
    );
    const path = (/** @type {Pair[]} */ places) => places.map(([x, y]) => this.place(x + moved[0], y + moved[1]));
    pen.beginPath();
    for (const [x, y] of path(outline.unsafe)) pen.lineTo(x, y);
    pen.globalAlpha = 0.2;
    pen.fillStyle = theme.unsafe;
    pen.fill("evenodd");
    pen.globalAlpha = 1;
    line(pen, path(outline.border), theme.unsafe, 1.8);
  }

  /** @param {Pen} pen
   * @param {Run} run
   * @param {number} number
   * @param {Theme} theme */
  drawRun(pen, run, number, theme) {
    const states = run.tables.states;
    this.drawLinks(pen, states, theme);
    for (let point = 0; point < this.scene.points; point += 1) {
      const colour = theme.lines[point % theme.lines.length];
      const dash = number ? [3, 3] : [];
      const all = this.trails[number][point];
      const done = all.filter(({ time }) => time <= this.view.cursor);
      pen.globalAlpha = 0.3;
      line(pen, all.map((step) => this.place(step.x, step.y)), colour, 1.4, dash);
      pen.globalAlpha = number ? 0.6 : 1;
      const [x, y] = [0, 1].map((axis) => states.value(`q_${2 * point + axis}`, this.view.cursor));
      if (x === null || y === null) continue;
      const now = this.place(x, y);
      line(pen, [...done.map((step) => this.place(step.x, step.y)), now], colour, 2.2, dash);
      if (this.scene.arrows !== false) this.drawArrows(pen, run, point, now, theme);
      const heading = point === 0 && this.scene.heading ? states.value(this.scene.heading, this.view.cursor) : null;
      pen.beginPath();
      if (heading === null) pen.arc(now[0], now[1], 6, 0, 2 * Math.PI);
      else for (const corner of this.body([x, y], heading)) pen.lineTo(...this.place(...corner));
      pen.closePath();
      pen.fillStyle = colour;
      pen.fill();
      pen.lineWidth = 1.5;
      pen.strokeStyle = theme.paper;
      pen.stroke();
      pen.globalAlpha = 1;
    }
  }

  /** Returns the corners of the robot's body at a place, turned by its heading.
   * @param {Pair} place
   * @param {number} heading
   * @returns {Pair[]} */
  body([x, y], heading) {
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    return (this.scene.outline ?? []).map(([forward, left]) => [x + c * forward - s * left, y + s * forward + c * left]);
  }

  /** @param {Pen} pen
   * @param {import("./signal_table.js").SignalTable} states
   * @param {Theme} theme */
  drawLinks(pen, states, theme) {
    const at = (/** @type {number} */ point) => {
      const [x, y] = [0, 1].map((axis) => states.value(`q_${2 * point + axis}`, this.view.cursor));
      return x === null || y === null ? [] : [this.place(x, y)];
    };
    for (const link of this.scene.links ?? []) {
      line(pen, link.flatMap(at), theme.quiet, 4);
    }
  }

  /** @param {Pen} pen
   * @param {Run} run
   * @param {number} point
   * @param {Pair} from
   * @param {Theme} theme */
  drawArrows(pen, run, point, from, theme) {
    for (const { kind, dash } of [{ kind: "asked", dash: [4, 3] }, { kind: "sent", dash: [] }]) {
      const names = [0, 1].map((axis) => `${kind}_${2 * point + axis}`);
      if (!names.every((name) => run.tables.ticks.has(name))) continue;
      const u = names.map((name) => run.tables.ticks.range(name, this.view.cursor)?.[1] ?? 0);
      const [dx, dy] = [(u[0] / this.largest) * ARROW_PX, (-u[1] / this.largest) * ARROW_PX];
      if (Math.hypot(dx, dy) < 3) continue;
      /** @type {Pair} */
      const tip = [from[0] + dx, from[1] + dy];
      line(pen, [from, tip], theme.ink, 1.5, dash);
      const angle = Math.atan2(dy, dx);
      /** @type {(turn: number) => Pair} */
      const barb = (turn) => [tip[0] - 7 * Math.cos(angle + turn), tip[1] - 7 * Math.sin(angle + turn)];
      line(pen, [barb(0.4), tip, barb(-0.4)], theme.ink, 1.5);
    }
  }
}
