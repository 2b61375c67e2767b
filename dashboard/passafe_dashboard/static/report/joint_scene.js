// The scene of a robot without a place in the plane: its joints between their limits, at the cursor.

import { line, prepare } from "./drawing.js";
import { numberText } from "./number_text.js";

const JOINT = 30;

/** @typedef {import("./payload.js").Run} Run */

/** @typedef {import("./theme.js").Theme} Theme */

/** @typedef {CanvasRenderingContext2D} Pen */

export class JointScene {
  /** @param {HTMLCanvasElement} canvas
   * @param {Run[]} runs
   * @param {import("./time_view.js").TimeView} view */
  constructor(canvas, runs, view) {
    this.canvas = canvas;
    this.runs = runs;
    this.view = view;
    const { joints } = /** @type {import("./payload.js").JointPicture} */ (runs[0].scene);
    this.joints = joints.map((joint) => ({ ...joint, ...this.reach(joint) }));
  }

  /** Returns lowest and highest angle to show: the limits and what the run reached.
   * @param {import("./payload.js").Joint} joint */
  reach(joint) {
    const values = this.runs.flatMap((run) => [...run.tables.states.envelope(joint.column).low]);
    const known = [joint.low, joint.high, ...values].flatMap((value) => (value === null || Number.isNaN(value) ? [] : [value]));
    const from = known.reduce((least, value) => Math.min(least, value), Infinity);
    const to = known.reduce((most, value) => Math.max(most, value), -Infinity);
    const margin = Math.max(0.05 * (to - from), 0.01);
    return { from: from - margin, to: to + margin };
  }

  /** @param {Theme} theme */
  draw(theme) {
    const width = this.canvas.clientWidth;
    const height = this.joints.length * JOINT + 14;
    const pen = prepare(this.canvas, width, height);
    pen.font = "11px system-ui, sans-serif";
    this.joints.forEach((joint, row) => this.drawJoint(pen, joint, 7 + row * JOINT, width, theme));
  }

  /** @param {Pen} pen
   * @param {import("./payload.js").Joint & {from: number, to: number}} joint
   * @param {number} top
   * @param {number} width
   * @param {Theme} theme */
  drawJoint(pen, joint, top, width, theme) {
    const [left, right] = [56, width - 64];
    const middle = top + JOINT / 2;
    const x = (/** @type {number} */ value) => left + ((value - joint.from) / (joint.to - joint.from)) * (right - left);
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
