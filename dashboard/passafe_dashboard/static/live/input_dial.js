// Inputs around a point: what was asked, what was allowed, and the directions that are held back now.
// All are the operator's part of the input: what the robot's own feedback adds is taken off.

/** @typedef {import("./types.js").Pair} Pair
 * @typedef {import("./types.js").Held} Held */

/** A cut of the dial: directions beyond a chord are held back.
 * @typedef {{angle: number, half: number, name: string}} Cut */

/** Returns what was asked of an operator's axes and what was allowed of it, as numbers of the input.
 * Where the input is no acceleration of the point, as with a car, what it amounts to is sent beside it.
 * @param {{u_h: number[], u: number[], u_nominal: number[], pushes?: {asked: number[], allowed: number[]}}} filter
 * @param {number[]} axes
 * @returns {{asked: number[], allowed: number[]}} */
export function askedAndAllowed(filter, axes) {
  const { pushes } = filter;
  if (pushes) return { asked: axes.map((axis) => pushes.asked[axis] ?? 0), allowed: axes.map((axis) => pushes.allowed[axis] ?? 0) };
  return {
    asked: axes.map((axis) => filter.u_h[axis] ?? 0),
    allowed: axes.map((axis) => (filter.u[axis] ?? 0) - (filter.u_nominal[axis] ?? 0) + (filter.u_h[axis] ?? 0)),
  };
}

/** Returns the filter's decision if it drives the robot now: it is old when messages are, and the fail-safe law drives
 * after an emergency stop or without inputs.
 * @param {import("./types.js").Now} now */
export function decisionInForce(now) {
  return now.liveness.state === "live" && now.plant?.phase !== "FAIL_SAFE" ? now.filter : null;
}

/** Returns the cuts of a dial whose rim is a full command.
 * @param {Held[]} held of one point
 * @param {number[]} allowed the operator's part of the decision
 * @param {number} full the input at the rim
 * @returns {Cut[]} */
export function cuts(held, allowed, full) {
  const found = [];
  for (const { name, towards, margin } of held) {
    const offset = (towards[0] * allowed[0] + towards[1] * allowed[1] + Math.max(margin, 0)) / full;
    if (!(offset < 1)) continue;
    found.push({ name, angle: Math.atan2(towards[1], towards[0]), half: Math.acos(Math.max(offset, -1)) });
  }
  return found;
}

/** Draws the held-back parts of a dial.
 * @param {CanvasRenderingContext2D} pen
 * @param {Pair} centre
 * @param {number} radius
 * @param {Cut[]} found
 * @param {string} colour */
export function drawCuts(pen, centre, radius, found, colour) {
  pen.fillStyle = colour;
  pen.strokeStyle = colour;
  pen.lineWidth = 1.5;
  for (const { angle, half } of found) {
    pen.beginPath();
    pen.arc(centre[0], centre[1], radius, -angle - half, -angle + half);
    pen.closePath();
    pen.globalAlpha = 0.32;
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
  }
}

/** Draws an arrow from a place; one that is shorter than a few pixels is left out.
 * @param {CanvasRenderingContext2D} pen
 * @param {Pair} from
 * @param {Pair} by pixels, right and up
 * @param {{colour: string, width: number, dash?: number[]}} look */
export function drawArrow(pen, from, by, { colour, width, dash = [] }) {
  const length = Math.hypot(by[0], by[1]);
  if (length < 3) return;
  const tip = [from[0] + by[0], from[1] - by[1]];
  const angle = Math.atan2(-by[1], by[0]);
  const barb = Math.min(5 + 1.6 * width, 0.6 * length);
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.lineCap = "round";
  pen.setLineDash(dash);
  pen.beginPath();
  pen.moveTo(from[0], from[1]);
  pen.lineTo(tip[0], tip[1]);
  pen.stroke();
  pen.setLineDash([]);
  pen.beginPath();
  for (const turn of [0.45, -0.45]) {
    pen.moveTo(tip[0], tip[1]);
    pen.lineTo(tip[0] - barb * Math.cos(angle + turn), tip[1] - barb * Math.sin(angle + turn));
  }
  pen.stroke();
}

/** The input at the rim of a dial: a full command, or more while more was asked, as a script may.
 * It grows at once and shrinks slowly, so that arrows do not change their length for no reason. */
export class DialScale {
  /** @param {number} full */
  constructor(full) {
    this.full = full;
    this.value = full;
  }

  /** @param {number} asked size of what was asked */
  follow(asked) {
    const wanted = Math.max(this.full, asked);
    this.value = wanted > this.value ? wanted : this.value + 0.01 * (wanted - this.value);
    return this.value;
  }
}
