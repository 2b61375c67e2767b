// The ground of the plane: grid, and the outlines of what the robot keeps away from. It is drawn when it has changed.

import { multiples, roundStep, tickText } from "../report/axis.js";
import { line } from "../report/drawing.js";
import { CORNER_PX, LiveCanvas } from "./live_canvas.js";
import { ShownLook } from "./shown_look.js";

/** @typedef {import("./types.js").Pair} Pair
 * @typedef {import("./theme.js").LiveTheme} Theme */

export class PlaneGround {
  /** @param {HTMLCanvasElement} canvas
   * @param {import("./types.js").Plane} scene
   * @param {import("./camera.js").Camera} camera */
  constructor(canvas, scene, camera) {
    this.canvas = new LiveCanvas(canvas);
    this.scene = scene;
    this.camera = camera;
    this.look = new ShownLook();
  }

  /** @param {Record<string, Pair>} moves of outlines that move, m
   * @param {Theme} theme */
  draw(moves, theme) {
    const { camera } = this;
    const shifts = Object.values(moves).flat();
    const places = [...camera.pixel(0, 0), 100 * Math.log(camera.scale), ...shifts.map((shift) => shift * camera.scale)];
    if (!this.canvas.width || !this.look.isNew(places, [...this.canvas.frame, theme], 0)) return;
    const pen = this.canvas.clear();
    pen.save();
    pen.beginPath();
    pen.roundRect(0, 0, camera.width, camera.height, CORNER_PX);
    pen.clip();
    const drawn = this.scene.outlines.map((outline) => {
      const [dx, dy] = outline.moving === null ? [0, 0] : (moves[`moving_${outline.moving}`] ?? [0, 0]);
      /** @param {Pair[]} corners */
      const path = (corners) => corners.map(([x, y]) => camera.pixel(x + dx, y + dy));
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
    pen.restore();
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
}
