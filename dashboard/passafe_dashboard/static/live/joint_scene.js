// The live scene of joints: each between its limits, with what was asked and what was allowed.

import { askedAndAllowed, decisionInForce, drawArrow } from "./input_dial.js";
import { LiveCanvas } from "./live_canvas.js";
import { ShownLook } from "./shown_look.js";

/** @typedef {import("./types.js").Now} Now */

const MOST_ROW = 96;
const LEFT = 84;
const RIGHT = 96;

/** Returns an angle in degrees with one place, as people read it.
 * @param {number} value rad */
export function angleText(value) {
  const degrees = Math.round((value * 1800) / Math.PI) / 10;
  return `${degrees < 0 ? "−" : ""}${Math.abs(degrees).toFixed(1)}°`;
}

/** Returns lowest and highest value to show of a joint: its limits with some room, wider while it is beyond them.
 * @param {{low: number | null, high: number | null}} joint
 * @param {number} value
 * @returns {[number, number]} */
export function jointRange({ low, high }, value) {
  const from = Math.min(low ?? -Math.PI, value);
  const to = Math.max(high ?? Math.PI, value);
  const room = 0.08 * Math.max(to - from, 0.1);
  return [from - room, to + room];
}

export class JointScene {
  /** @param {HTMLCanvasElement} ground
   * @param {HTMLCanvasElement} canvas
   * @param {import("./types.js").Joints} scene
   * @param {number[]} full the greatest command of each axis */
  constructor(ground, canvas, scene, full) {
    this.canvas = new LiveCanvas(canvas);
    this.look = new ShownLook();
    this.scene = scene;
    this.full = full;
    ground.hidden = true;
  }

  /** @param {Now} now
   * @param {any} theme */
  draw(now, theme) {
    const { width, height } = this.canvas;
    if (!width || !height || !this.look.isNew(this.lookOf(now), [...this.canvas.frame, theme, now.liveness.state])) return;
    const pen = this.canvas.clear();
    if (!now.plant) return;
    const row = Math.min(height / (this.scene.joints.length + 0.5), MOST_ROW);
    const top = (height - row * this.scene.joints.length) / 2;
    this.scene.joints.forEach((joint, i) => this.drawJoint(pen, now, i, joint, top + (i + 0.5) * row, width, theme));
  }

  /** Returns the numbers of which the picture depends: a full range or a full command are a hundred steps and more.
   * @param {Now} now
   * @returns {number[]} */
  lookOf(now) {
    const decision = decisionInForce(now);
    const inputs = this.scene.joints.map((_, i) => (decision ? askedAndAllowed(decision, [i]) : { asked: [0], allowed: [0] }));
    const angles = this.scene.joints.map((_, i) => 200 * (now.plant?.x[i] ?? 0));
    return [...angles, ...inputs.flatMap(({ asked, allowed }, i) => [asked[0], allowed[0]].map((input) => (80 * input) / (this.full[i] ?? 10)))];
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Now} now
   * @param {number} index
   * @param {import("./types.js").Joint} joint
   * @param {number} middle
   * @param {number} width
   * @param {any} theme */
  drawJoint(pen, now, index, joint, middle, width, theme) {
    const value = now.plant.x[index];
    const [from, to] = jointRange(joint, value);
    const old = now.liveness.state !== "live";
    const x = (/** @type {number} */ angle) => LEFT + ((angle - from) / (to - from)) * (width - LEFT - RIGHT);
    pen.font = "13px system-ui, sans-serif";
    pen.textBaseline = "middle";
    pen.textAlign = "left";
    pen.fillStyle = theme.ink;
    pen.fillText(joint.name, 14, middle);
    pen.fillStyle = theme.sunken;
    pen.fillRect(LEFT, middle - 5, width - LEFT - RIGHT, 10);
    pen.fillStyle = theme.unsafe;
    pen.globalAlpha = 0.3;
    if (joint.low !== null) pen.fillRect(LEFT, middle - 5, x(joint.low) - LEFT, 10);
    if (joint.high !== null) pen.fillRect(x(joint.high), middle - 5, width - RIGHT - x(joint.high), 10);
    pen.globalAlpha = 1;
    for (const bound of [joint.low, joint.high]) if (bound !== null) pen.fillRect(x(bound) - 1, middle - 14, 2.5, 28);
    this.drawInputs(pen, now, index, x(value), middle, theme);
    pen.beginPath();
    pen.arc(x(value), middle, 9, 0, 2 * Math.PI);
    pen.fillStyle = old ? theme.quiet : theme.lines[0];
    pen.fill();
    pen.lineWidth = 2.5;
    pen.strokeStyle = theme.raised;
    pen.stroke();
    pen.fillStyle = theme.ink;
    pen.textAlign = "right";
    pen.fillText(angleText(value), width - 16, middle);
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Now} now
   * @param {number} index
   * @param {number} x
   * @param {number} middle
   * @param {any} theme */
  drawInputs(pen, now, index, x, middle, theme) {
    const decision = decisionInForce(now);
    if (!decision) return;
    const { asked, allowed } = askedAndAllowed(decision, [index]);
    const factor = 80 / Math.max(this.full[index] ?? 10, Math.abs(asked[0]), Math.abs(allowed[0]));
    drawArrow(pen, [x, middle - 19], [allowed[0] * factor, 0], { colour: theme.accent, width: 4 });
    drawArrow(pen, [x, middle + 19], [asked[0] * factor, 0], { colour: theme.ink, width: 2, dash: [6, 4] });
  }
}
