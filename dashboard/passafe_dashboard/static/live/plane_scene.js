// The live scene in the plane: ground with outlines, and above it robot, trail, inputs and what is held back.

import { ageText } from "./delays_panel.js";
import { multiples, roundStep, tickText } from "../report/axis.js";
import { line } from "../report/drawing.js";
import { Camera, MARGIN_PX } from "./camera.js";
import { DialScale, askedAndAllowed, cuts, decisionInForce, drawArrow, drawCuts } from "./input_dial.js";

/** @typedef {import("./types.js").Pair} Pair
 * @typedef {import("./types.js").Plane} Plane
 * @typedef {import("./types.js").Now} Now
 * @typedef {import("./theme.js").LiveTheme} Theme */

const TRAIL_S = 12;
const TRAIL_PIECES = 6;
const ROBOT_PX = 9;
const VELOCITY_S = 0.4;
const OLD_MS = 60;
const MOST_TRAILS = 2;

export class PlaneScene {
  /** @param {HTMLCanvasElement} ground
   * @param {HTMLCanvasElement} canvas
   * @param {Plane} scene
   * @param {import("./live_table.js").LiveTable} states
   * @param {number[]} full the greatest command of each axis, units of u */
  constructor(ground, canvas, scene, states, full) {
    this.ground = ground;
    this.canvas = canvas;
    this.scene = scene;
    this.states = states;
    this.camera = new Camera(scene.bounds);
    this.scales = Array.from({ length: scene.points }, (_, i) => new DialScale(full[2 * i] ?? full[0] ?? 10));
    this.columns = Array.from({ length: Math.min(scene.points, MOST_TRAILS) }, (_, i) => [`p${2 * i + 1}_m`, `p${2 * i + 2}_m`]);
  }

  /** @param {Now} now
   * @param {Theme} theme
   * @param {boolean} [restyled] whether colours have changed */
  draw(now, theme, restyled = false) {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!width || !height) return;
    const places = this.places(now);
    const moved = this.camera.aim(width, height, places);
    const moves = now.plant?.moved_m ?? {};
    if (moved || restyled || Object.keys(moves).length) this.drawGround(moves, theme);
    const pen = clear(this.canvas, width, height);
    const old = now.liveness.state !== "live";
    for (const link of this.scene.links ?? []) {
      const ends = link.filter((point) => places[point]).map((point) => this.camera.pixel(...places[point]));
      line(pen, ends, theme.quiet, 4);
    }
    places.forEach((place, point) => this.drawPoint(pen, now, point, place, theme, old));
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

  /** @param {Record<string, Pair>} moves
   * @param {Theme} theme */
  drawGround(moves, theme) {
    const { camera } = this;
    const pen = clear(this.ground, camera.width, camera.height);
    const drawn = this.scene.outlines.map((outline) => {
      const [dx, dy] = outline.moving === null ? [0, 0] : (moves[`moving_${outline.moving}`] ?? [0, 0]);
      /** @param {Pair[]} places */
      const path = (places) => places.map(([x, y]) => camera.pixel(x + dx, y + dy));
      return { outline, unsafe: path(outline.unsafe), border: path(outline.border) };
    });
    pen.fillStyle = theme["unsafe-wash"];
    for (const { unsafe } of drawn) {
      pen.beginPath();
      for (const [x, y] of unsafe) pen.lineTo(x, y);
      pen.fill("evenodd");
    }
    this.drawGrid(pen, theme);
    for (const { outline, border } of drawn) {
      line(pen, border, theme.unsafe, 2);
      this.drawName(pen, outline, border, theme);
    }
  }

  /** Writes the name of a bounded outline into it.
   * @param {CanvasRenderingContext2D} pen
   * @param {import("./types.js").Outline} outline
   * @param {Pair[]} border
   * @param {Theme} theme */
  drawName(pen, outline, border, theme) {
    if (!outline.bounded) return;
    const [x, y] = [0, 1].map((axis) => border.reduce((sum, place) => sum + place[axis], 0) / border.length);
    pen.fillStyle = theme.quiet;
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(outline.names[0], x, y);
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Theme} theme */
  drawGrid(pen, theme) {
    const { camera } = this;
    const [low, high] = camera.view;
    const step = roundStep(camera.width / camera.scale, Math.max(camera.width / 110, 2));
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = theme.quiet;
    for (const x of multiples(low[0], high[0], step)) {
      const [column] = camera.pixel(x, 0);
      line(pen, [[column, 0], [column, camera.height]], theme.grid);
      pen.textAlign = "center";
      if (column > 30) pen.fillText(tickText(x, step), column, camera.height - 6);
    }
    for (const y of multiples(low[1], high[1], step)) {
      const [, row] = camera.pixel(0, y);
      line(pen, [[0, row], [camera.width, row]], theme.grid);
      pen.textAlign = "left";
      if (row > 24 && row < camera.height - 24) pen.fillText(`${tickText(y, step)} m`, 5, row - 4);
    }
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Now} now
   * @param {number} point
   * @param {Pair} place
   * @param {Theme} theme
   * @param {boolean} old */
  drawPoint(pen, now, point, place, theme, old) {
    const colour = old ? theme.quiet : theme.lines[point % theme.lines.length];
    const here = this.camera.pixel(...place);
    this.drawTrail(pen, point, here, colour);
    this.drawVelocity(pen, now, point, here, theme);
    this.drawInputs(pen, now, point, here, theme);
    this.drawKnown(pen, now, point, theme);
    pen.beginPath();
    const body = point === 0 && typeof now.plant.heading === "number" ? (this.scene.outline ?? []) : [];
    if (body.length) for (const corner of turned(body, place, now.plant.heading)) pen.lineTo(...this.camera.pixel(...corner));
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

  /** @param {CanvasRenderingContext2D} pen
   * @param {number} point
   * @param {Pair} here
   * @param {string} colour */
  drawTrail(pen, point, here, colour) {
    if (!this.columns[point]) return;
    const [x, y] = this.columns[point].map((column) => this.states.envelope(column).low);
    const { end, newest } = this.states;
    const first = Math.max(this.states.at(newest - TRAIL_S), 0);
    const each = Math.max(Math.ceil((end.length - first) / TRAIL_PIECES), 1);
    for (let begin = first; begin < end.length; begin += each) {
      pen.globalAlpha = 0.15 + 0.6 * ((begin - first) / Math.max(end.length - first, 1));
      const places = [];
      for (let i = begin; i <= Math.min(begin + each, end.length - 1); i += 1) {
        if (!Number.isNaN(x[i])) places.push(this.camera.pixel(x[i], y[i]));
      }
      if (begin + each >= end.length) places.push(here);
      line(pen, places, colour, 2.5);
    }
    pen.globalAlpha = 1;
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Now} now
   * @param {number} point
   * @param {Pair} here
   * @param {Theme} theme */
  drawVelocity(pen, now, point, here, theme) {
    const first = this.scene.velocities + 2 * point;
    const { x, velocities } = now.plant;
    const velocity = velocities ? velocities[point] : [x[first], x[first + 1]];
    if (!velocity) return;
    const factor = VELOCITY_S * this.camera.scale;
    drawArrow(pen, here, [velocity[0] * factor, velocity[1] * factor], { colour: theme.quiet, width: 2 });
  }

  /** @param {CanvasRenderingContext2D} pen
   * @param {Now} now
   * @param {number} point
   * @param {Pair} here
   * @param {Theme} theme */
  drawInputs(pen, now, point, here, theme) {
    const decision = decisionInForce(now);
    if (!decision || !this.scales[point]) return;
    const { asked, allowed } = askedAndAllowed(decision, [2 * point, 2 * point + 1]);
    const radius = Math.min(this.camera.width / 5, this.camera.height / 5, MARGIN_PX) - 4;
    const full = this.scales[point].follow(Math.hypot(asked[0], asked[1]));
    pen.beginPath();
    pen.arc(here[0], here[1], radius, 0, 2 * Math.PI);
    pen.lineWidth = 1;
    pen.strokeStyle = theme.quiet;
    pen.globalAlpha = 0.55;
    pen.stroke();
    pen.globalAlpha = 1;
    drawCuts(pen, here, radius, cuts(now.held.filter((each) => each.point === point), allowed, full), theme.held);
    const factor = radius / full;
    /** @param {number[]} input
     * @returns {Pair} */
    const within = (input) => {
      const shrink = factor * Math.min(1, (1.25 * full) / Math.max(Math.hypot(input[0], input[1]), 1e-9));
      return [input[0] * shrink, input[1] * shrink];
    };
    drawArrow(pen, here, within(allowed), { colour: theme.accent, width: 4.5 });
    drawArrow(pen, here, within(asked), { colour: theme.ink, width: 2, dash: [6, 4] });
  }

  /** Draws where the filter knows the robot to be, if that is old.
   * @param {CanvasRenderingContext2D} pen
   * @param {Now} now
   * @param {number} point
   * @param {Theme} theme */
  drawKnown(pen, now, point, theme) {
    const age = now.ages?.state_ms ?? null;
    if (age === null || age < OLD_MS || !now.plant || !this.columns[point]) return;
    const at = now.plant.time_s - age / 1000;
    const [x, y] = this.columns[point].map((column) => this.states.value(column, at));
    if (x === null || y === null) return;
    const [left, top] = this.camera.pixel(x, y);
    pen.beginPath();
    pen.arc(left, top, ROBOT_PX, 0, 2 * Math.PI);
    pen.lineWidth = 2;
    pen.strokeStyle = theme.quiet;
    pen.setLineDash([3, 3]);
    pen.stroke();
    pen.setLineDash([]);
    label(pen, `${ageText(age)} old`, left + ROBOT_PX + 5, top + ROBOT_PX + 8, theme.quiet, "left");
  }
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

/** Returns a pen on an empty canvas; its size is set only where it has changed.
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height
 * @returns {CanvasRenderingContext2D} */
export function clear(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return pen;
}
