// The live scene in the plane: above the ground the robot, its trail, its inputs and what is held back.

import { ageText } from "./delays_panel.js";
import { line } from "../report/drawing.js";
import { Camera, MARGIN_PX } from "./camera.js";
import { DialScale, askedAndAllowed, cuts, decisionInForce, drawArrow, drawCuts } from "./input_dial.js";
import { LiveCanvas } from "./live_canvas.js";
import { PlaneGround } from "./plane_ground.js";
import { ShownLook } from "./shown_look.js";

/** @typedef {import("./types.js").Pair} Pair
 * @typedef {import("./types.js").Plane} Plane
 * @typedef {import("./types.js").Now} Now
 * @typedef {import("./theme.js").LiveTheme} Theme */

/** Inputs around a point, pixels right and up, and the directions that are held back.
 * @typedef {{radius: number, asked: Pair, allowed: Pair, cuts: import("./input_dial.js").Cut[]}} Dial */

/** What is drawn of a point, pixels: where it is, its velocity, its inputs, and where the filter knows it to be if that is old.
 * @typedef {{here: Pair, velocity: Pair | null, dial: Dial | null, known: {at: Pair, text: string} | null}} PointLook */

const TRAIL_S = 12;
const TRAIL_PIECES = 6;
const ROBOT_PX = 9;
const VELOCITY_S = 0.4;
const OLD_MS = 60;
const MOST_TRAILS = 2;
const BEYOND_RIM = 1.25;

export class PlaneScene {
  /** @param {HTMLCanvasElement} ground
   * @param {HTMLCanvasElement} canvas
   * @param {Plane} scene
   * @param {import("./live_table.js").LiveTable} states
   * @param {number[]} full the greatest command of each axis, units of u */
  constructor(ground, canvas, scene, states, full) {
    this.canvas = new LiveCanvas(canvas);
    this.scene = scene;
    this.states = states;
    this.camera = new Camera(scene.bounds);
    this.ground = new PlaneGround(ground, scene, this.camera);
    this.look = new ShownLook();
    this.scales = Array.from({ length: scene.points }, (_, i) => new DialScale(full[2 * i] ?? full[0] ?? 10));
    this.columns = Array.from({ length: Math.min(scene.points, MOST_TRAILS) }, (_, i) => [`p${2 * i + 1}_m`, `p${2 * i + 2}_m`]);
  }

  /** @param {Now} now
   * @param {Theme} theme */
  draw(now, theme) {
    const { width, height } = this.canvas;
    if (!width || !height) return;
    const places = this.places(now);
    this.camera.aim(width, height, places);
    this.ground.draw(now.plant?.moved_m ?? {}, now.gaps.find(({ nearest }) => nearest)?.name, theme);
    const looks = places.map((place, point) => this.lookOf(now, point, place));
    const old = now.liveness.state !== "live";
    const heading = now.plant?.heading ?? 0;
    const pixels = [...looks.flatMap(numbersOf), 100 * heading, 100 * Math.log(this.camera.scale)];
    if (!this.look.isNew(pixels, [...this.canvas.frame, theme, old, ...looks.map(({ known }) => known?.text)])) return;
    const body = typeof now.plant?.heading === "number" && places.length ? turned(this.scene.outline ?? [], places[0], heading) : [];
    const outline = body.map(([x, y]) => this.camera.pixel(x, y));
    const pen = this.canvas.clear();
    for (const link of this.scene.links ?? []) {
      line(pen, link.filter((point) => looks[point]).map((point) => looks[point].here), theme.quiet, 4);
    }
    looks.forEach((look, point) => this.drawPoint(pen, look, point, point ? [] : outline, theme, old));
  }

  /** Returns the place of each point, all of one state.
   * @param {Now} now
   * @returns {Pair[]} */
  places(now) {
    if (now.plant?.places) return now.plant.places;
    const x = now.plant?.x;
    if (!x) return [];
    return Array.from({ length: this.scene.points }, (_, i) => [x[2 * i], x[2 * i + 1]]);
  }

  /** @param {Now} now
   * @param {number} point
   * @param {Pair} place
   * @returns {PointLook} */
  lookOf(now, point, place) {
    return { here: this.camera.pixel(...place), velocity: this.velocityOf(now, point), dial: this.dialOf(now, point), known: this.knownOf(now, point) };
  }

  /** @param {Now} now
   * @param {number} point
   * @returns {Pair | null} */
  velocityOf(now, point) {
    const first = this.scene.velocities + 2 * point;
    const { x, velocities } = now.plant;
    const velocity = velocities ? velocities[point] : [x[first], x[first + 1]];
    const factor = VELOCITY_S * this.camera.scale;
    return velocity ? [velocity[0] * factor, velocity[1] * factor] : null;
  }

  /** @param {Now} now
   * @param {number} point
   * @returns {Dial | null} */
  dialOf(now, point) {
    const decision = decisionInForce(now);
    if (!decision || !this.scales[point]) return null;
    const { asked, allowed } = askedAndAllowed(decision, [2 * point, 2 * point + 1]);
    const radius = Math.min(this.camera.width / 5, this.camera.height / 5, MARGIN_PX) - 4;
    const full = this.scales[point].follow(Math.hypot(asked[0], asked[1]));
    const factor = radius / full;
    /** @param {number[]} input
     * @returns {Pair} */
    const within = (input) => {
      const shrink = factor * Math.min(1, (BEYOND_RIM * full) / Math.max(Math.hypot(input[0], input[1]), 1e-9));
      return [input[0] * shrink, input[1] * shrink];
    };
    const held = now.held.filter((each) => each.point === point);
    return { radius, asked: within(asked), allowed: within(allowed), cuts: cuts(held, allowed, full) };
  }

  /** Returns where the filter knows the robot to be, if that is old.
   * @param {Now} now
   * @param {number} point
   * @returns {PointLook["known"]} */
  knownOf(now, point) {
    const age = now.ages?.state_ms ?? null;
    if (age === null || age < OLD_MS || !now.plant || !this.columns[point]) return null;
    const silent_s = now.topics.find(({ topic }) => topic === "state")?.age_s ?? 0; // the plant's clock went on since
    const at = now.plant.time_s + silent_s - age / 1000;
    const [x, y] = this.columns[point].map((column) => this.states.value(column, at));
    return x === null || y === null ? null : { at: this.camera.pixel(x, y), text: `${ageText(age)} old` };
  }

  /** Returns the trail of a point up to where it is now; NaN where it is not known.
   * @param {number} point
   * @param {Pair} here
   * @returns {Pair[]} */
  trailOf(point, here) {
    if (!this.columns[point]) return [];
    const [x, y] = this.columns[point].map((column) => this.states.envelope(column).low);
    const { end, newest } = this.states;
    /** @type {Pair[]} */
    const places = [];
    for (let i = Math.max(this.states.at(newest - TRAIL_S), 0); i < end.length; i += 1) places.push(this.camera.pixel(x[i], y[i]));
    places.push(here);
    return places;
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {PointLook} look
   * @param {number} point
   * @param {Pair[]} outline the robot's own; empty: a disk
   * @param {Theme} theme
   * @param {boolean} old */
  drawPoint(pen, look, point, outline, theme, old) {
    const { here, velocity, dial, known } = look;
    const colour = old ? theme.quiet : theme.lines[point % theme.lines.length];
    drawTrail(pen, this.trailOf(point, here), colour);
    if (velocity) drawArrow(pen, here, velocity, { colour: theme.quiet, width: 2 });
    if (dial) drawDial(pen, here, dial, theme);
    if (known) drawKnown(pen, known, theme);
    pen.beginPath();
    if (outline.length) for (const [x, y] of outline) pen.lineTo(x, y);
    else pen.arc(here[0], here[1], ROBOT_PX, 0, 2 * Math.PI);
    pen.closePath();
    pen.fillStyle = old ? theme.raised : colour;
    pen.fill();
    pen.lineWidth = 2.5;
    pen.strokeStyle = old ? colour : theme.raised;
    pen.setLineDash(old ? [4, 3] : []);
    pen.stroke();
    pen.setLineDash([]);
    if (this.scene.points > 1) label(pen, `${point + 1}`, here[0], here[1], old ? theme.ink : theme.raised, "center");
  }
}

/** Returns the numbers of which the picture of a point depends, pixels.
 * @param {PointLook} look */
export function numbersOf({ here, velocity, dial, known }) {
  const angles = (dial?.cuts ?? []).flatMap(({ angle, half }) => [angle, half]).map((angle) => angle * (dial?.radius ?? 0));
  return [...here, ...(velocity ?? []), ...(dial ? [dial.radius, ...dial.asked, ...dial.allowed] : []), ...angles, ...(known?.at ?? [])];
}

/** @param {CanvasRenderingContext2D} pen
 * @param {Pair[]} trail
 * @param {string} colour */
function drawTrail(pen, trail, colour) {
  const each = Math.max(Math.ceil((trail.length - 1) / TRAIL_PIECES), 1);
  for (let begin = 0; begin + 1 < trail.length; begin += each) {
    pen.globalAlpha = 0.15 + 0.6 * (begin / Math.max(trail.length - 1, 1));
    line(pen, trail.slice(begin, begin + each + 1).filter(([x]) => !Number.isNaN(x)), colour, 2.5);
  }
  pen.globalAlpha = 1;
}

/** @param {CanvasRenderingContext2D} pen
 * @param {Pair} here
 * @param {Dial} dial
 * @param {Theme} theme */
function drawDial(pen, here, dial, theme) {
  pen.beginPath();
  pen.arc(here[0], here[1], dial.radius, 0, 2 * Math.PI);
  pen.lineWidth = 1;
  pen.strokeStyle = theme.quiet;
  pen.globalAlpha = 0.55;
  pen.stroke();
  pen.globalAlpha = 1;
  drawCuts(pen, here, dial.radius, dial.cuts, theme.held);
  drawArrow(pen, here, dial.allowed, { colour: theme.accent, width: 4.5 });
  drawArrow(pen, here, dial.asked, { colour: theme.ink, width: 2, dash: [6, 4] });
}

/** Draws where the filter knows the robot to be.
 * @param {CanvasRenderingContext2D} pen
 * @param {{at: Pair, text: string}} known
 * @param {Theme} theme */
function drawKnown(pen, { at: [left, top], text }, theme) {
  pen.beginPath();
  pen.arc(left, top, ROBOT_PX, 0, 2 * Math.PI);
  pen.lineWidth = 2;
  pen.strokeStyle = theme.quiet;
  pen.setLineDash([3, 3]);
  pen.stroke();
  pen.setLineDash([]);
  label(pen, text, left + ROBOT_PX + 5, top + ROBOT_PX + 8, theme.quiet, "left");
}

/** Returns the corners of a body at a place, turned by its heading.
 * @param {Pair[]} corners
 * @param {Pair} place
 * @param {number} heading
 * @returns {Pair[]} */
export function turned(corners, place, heading) {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return corners.map(([x, y]) => [place[0] + c * x - s * y, place[1] + s * x + c * y]);
}

/** @param {CanvasRenderingContext2D} pen
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} colour
 * @param {CanvasTextAlign} align */
function label(pen, text, x, y, colour, align) {
  pen.font = "600 12px system-ui, sans-serif";
  pen.textAlign = align;
  pen.textBaseline = "middle";
  pen.fillStyle = colour;
  pen.fillText(text, x, y);
}
