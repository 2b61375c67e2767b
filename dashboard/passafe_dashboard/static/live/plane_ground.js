// The ground of the plane: grid, and the outlines of what the robot keeps away from. It is drawn when it has changed.

import { multiples, roundStep, tickText } from "../report/axis.js";
import { line } from "../report/drawing.js";
import { CORNER_PX, LiveCanvas } from "./live_canvas.js";
import { boxAround, middle, readableNames } from "./outline_names.js";
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
   * @param {string | undefined} nearest name of the nearest limit
   * @param {Theme} theme */
  draw(moves, nearest, theme) {
    const { camera } = this;
    const shifts = Object.values(moves).flat();
    const places = [...camera.pixel(0, 0), 100 * Math.log(camera.scale), ...shifts.map((shift) => shift * camera.scale)];
    if (!this.canvas.width || !this.look.isNew(places, [...this.canvas.frame, theme, nearest], 0)) return;
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
    for (const { border } of drawn) line(pen, border, theme.unsafe, 2);
    this.drawNames(pen, drawn.filter(({ outline }) => outline.bounded), nearest, theme);
    pen.restore();
  }

  /** Writes the names of bounded outlines into them, as far as each can be read.
   * @param {CanvasRenderingContext2D} pen
   * @param {{outline: import("./types.js").Outline, border: Pair[]}[]} bounded
   * @param {string | undefined} nearest
   * @param {Theme} theme */
  drawNames(pen, bounded, nearest, theme) {
    pen.fillStyle = theme.quiet;
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    const names = bounded.map(({ outline: { names: [text, ...others] }, border }) => {
      return { text, width: pen.measureText(text).width, outline: boxAround(border), nearest: [text, ...others].some((each) => each === nearest) };
    });
    for (const { text, outline } of readableNames(names)) pen.fillText(text, ...middle(outline));
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
