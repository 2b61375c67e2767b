// The scene at the cursor: robot, trail, obstacles and walls in the plane, or joints between their limits.

import { multiples, roundStep, tickText } from "./axis.js";
import { numberText } from "./number_text.js";

const MARGIN = 30;
const ARROW_PX = 60;
const JOINT = 30;
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

export class PlaneScene {
  /** @param {HTMLCanvasElement} canvas
   * @param {any[]} runs
   * @param {import("./time_view.js").TimeView} view */
  constructor(canvas, runs, view) {
    this.canvas = canvas;
    this.runs = runs;
    this.view = view;
    this.scene = runs[0].scene;
    this.trails = runs.map((run) => Array.from({ length: this.scene.points }, (_, point) => trail(run.tables.states, point)));
    this.bounds = this.findBounds();
    this.largest = this.largestInput();
  }

  /** Returns the rectangle that holds trails and bounded outlines, wherever they move. */
  findBounds() {
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

  displacements(outline) {
    if (outline.moving === null) return [[0, 0]];
    const [dx, dy] = [0, 1].map((axis) => this.runs[0].tables.states.envelope(`d_${outline.moving}_${axis}`).low);
    const stride = Math.max(1, Math.floor(dx.length / 500));
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

  inputs(run) {
    const columns = ["asked", "sent"].flatMap((kind) => [0, 1].map((axis) => `${kind}_${axis}`));
    return { table: run.tables.ticks, columns: columns.filter((name) => run.tables.ticks.has(name)) };
  }

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

  drawOutline(pen, outline, theme) {
    const states = this.runs[0].tables.states;
    const moved = [0, 1].map((axis) =>
      outline.moving === null ? 0 : (states.value(`d_${outline.moving}_${axis}`, this.view.cursor) ?? 0),
    );
    const path = (places) => places.map(([x, y]) => this.place(x + moved[0], y + moved[1]));
    pen.beginPath();
    for (const [x, y] of path(outline.unsafe)) pen.lineTo(x, y);
    pen.globalAlpha = 0.2;
    pen.fillStyle = theme.unsafe;
    pen.fill("evenodd");
    pen.globalAlpha = 1;
    line(pen, path(outline.border), theme.unsafe, 1.8);
  }

  drawRun(pen, run, number, theme) {
    const states = run.tables.states;
    this.drawLinks(pen, states, theme);
    for (let point = 0; point < this.scene.points; point += 1) {
      const colour = theme.lines[point % theme.lines.length];
      const dash = number ? [3, 3] : [];
      const all = this.trails[number][point];
      const done = all.filter(({ time }) => time <= this.view.cursor);
      pen.globalAlpha = 0.3;
      line(pen, all.map(({ x, y }) => this.place(x, y)), colour, 1.4, dash);
      pen.globalAlpha = number ? 0.6 : 1;
      const here = [0, 1].map((axis) => states.value(`q_${2 * point + axis}`, this.view.cursor));
      if (here[0] === null || here[1] === null) continue;
      const now = this.place(here[0], here[1]);
      line(pen, [...done.map(({ x, y }) => this.place(x, y)), now], colour, 2.2, dash);
      if (this.scene.arrows !== false) this.drawArrows(pen, run, point, now, theme);
      const heading = point === 0 && this.scene.heading ? states.value(this.scene.heading, this.view.cursor) : null;
      pen.beginPath();
      if (heading === null) pen.arc(now[0], now[1], 6, 0, 2 * Math.PI);
      else for (const corner of this.body(here, heading)) pen.lineTo(...this.place(...corner));
      pen.closePath();
      pen.fillStyle = colour;
      pen.fill();
      pen.lineWidth = 1.5;
      pen.strokeStyle = theme.paper;
      pen.stroke();
      pen.globalAlpha = 1;
    }
  }

  /** Returns the corners of the robot's body at a place, turned by its heading. */
  body([x, y], heading) {
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    return this.scene.outline.map(([forward, left]) => [x + c * forward - s * left, y + s * forward + c * left]);
  }

  drawLinks(pen, states, theme) {
    const at = (point) => [0, 1].map((axis) => states.value(`q_${2 * point + axis}`, this.view.cursor));
    for (const link of this.scene.links ?? []) {
      const ends = link.map(at).filter(([x, y]) => x !== null && y !== null);
      line(pen, ends.map(([x, y]) => this.place(x, y)), theme.quiet, 4);
    }
  }

  drawArrows(pen, run, point, from, theme) {
    for (const [kind, dash] of [["asked", [4, 3]], ["sent", []]]) {
      const names = [0, 1].map((axis) => `${kind}_${2 * point + axis}`);
      if (!names.every((name) => run.tables.ticks.has(name))) continue;
      const u = names.map((name) => run.tables.ticks.range(name, this.view.cursor)?.[1] ?? 0);
      const [dx, dy] = [(u[0] / this.largest) * ARROW_PX, (-u[1] / this.largest) * ARROW_PX];
      if (Math.hypot(dx, dy) < 3) continue;
      const tip = [from[0] + dx, from[1] + dy];
      line(pen, [from, tip], theme.ink, 1.5, dash);
      const angle = Math.atan2(dy, dx);
      const barb = (turn) => [tip[0] - 7 * Math.cos(angle + turn), tip[1] - 7 * Math.sin(angle + turn)];
      line(pen, [barb(0.4), tip, barb(-0.4)], theme.ink, 1.5);
    }
  }
}

export class JointScene {
  /** @param {HTMLCanvasElement} canvas
   * @param {any[]} runs
   * @param {import("./time_view.js").TimeView} view */
  constructor(canvas, runs, view) {
    this.canvas = canvas;
    this.runs = runs;
    this.view = view;
    this.joints = runs[0].scene.joints.map((joint) => ({ ...joint, ...this.reach(joint) }));
  }

  /** Returns lowest and highest angle to show: the limits and what the run reached. */
  reach(joint) {
    const values = this.runs.flatMap((run) => [...run.tables.states.envelope(joint.column).low]);
    const known = [joint.low, joint.high, ...values].filter((value) => value !== null && !Number.isNaN(value));
    const from = known.reduce((least, value) => Math.min(least, value), Infinity);
    const to = known.reduce((most, value) => Math.max(most, value), -Infinity);
    const margin = Math.max(0.05 * (to - from), 0.01);
    return { from: from - margin, to: to + margin };
  }

  draw(theme) {
    const width = this.canvas.clientWidth;
    const height = this.joints.length * JOINT + 14;
    const pen = prepare(this.canvas, width, height);
    pen.font = "11px system-ui, sans-serif";
    this.joints.forEach((joint, row) => this.drawJoint(pen, joint, 7 + row * JOINT, width, theme));
  }

  drawJoint(pen, joint, top, width, theme) {
    const [left, right] = [56, width - 64];
    const middle = top + JOINT / 2;
    const x = (value) => left + ((value - joint.from) / (joint.to - joint.from)) * (right - left);
    pen.textBaseline = "middle";
    pen.textAlign = "left";
    pen.fillStyle = theme.quiet;
    pen.fillText(joint.name, 4, middle);
    line(pen, [[left, middle], [right, middle]], theme.grid, 6);
    for (const bound of [joint.low, joint.high]) {
      if (bound !== null) line(pen, [[x(bound), top + 4], [x(bound), top + JOINT - 4]], theme.unsafe, 2);
    }
    this.runs.forEach((run, number) => {
      const value = run.tables.states.value(joint.column, this.view.cursor);
      if (value === null) return;
      pen.globalAlpha = number ? 0.5 : 1;
      pen.fillStyle = theme.lines[0];
      pen.beginPath();
      pen.arc(x(value), middle, 6, 0, 2 * Math.PI);
      pen.fill();
      pen.globalAlpha = 1;
      pen.fillStyle = theme.ink;
      if (!number) pen.fillText(numberText(value), right + 10, middle);
    });
  }
}

function prepare(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = `${height}px`;
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return pen;
}

export function line(pen, places, colour, width = 1, dash = []) {
  pen.beginPath();
  for (const [x, y] of places) pen.lineTo(x, y);
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.setLineDash(dash);
  pen.stroke();
  pen.setLineDash([]);
}
