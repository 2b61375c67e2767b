// A joystick on the page: drag it with mouse, pen or finger; what is held back now is shaded on it.

import { askedAndAllowed, cuts, decisionInForce, drawCuts } from "./input_dial.js";
import { LiveCanvas } from "./live_canvas.js";
import { ShownLook } from "./shown_look.js";
import { Stick, inDisk } from "./stick.js";

/** @typedef {import("./types.js").Pair} Pair */

const KNOB_PX = 17;

export class Pad {
  /** @param {number} number
   * @param {string} name
   * @param {number[]} axes
   * @param {number} size pixels
   * @param {{press: () => boolean, change: () => void}} hands whether the stick may be taken hold of; what a change calls */
  constructor(number, name, axes, size, hands) {
    this.number = number;
    this.axes = axes;
    this.size = size;
    this.stick = new Stick();
    this.hands = hands;
    /** @type {number | null} the finger, pen or mouse that holds the stick */
    this.pointer = null;
    this.canvas = document.createElement("canvas");
    this.canvas.className = "pad";
    this.canvas.id = `pad-${number}`;
    this.canvas.style.width = `${size}px`;
    this.canvas.style.height = `${size}px`;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${name}: drag to steer; by keyboard, hold the ${number ? "W A S D" : "arrow"} keys`);
    this.drawn = new LiveCanvas(this.canvas, [size, size]);
    this.look = new ShownLook();
    this.listen();
  }

  listen() {
    const { canvas, stick } = this;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button || stick.engaged || !this.hands.press()) return;
      this.pointer = event.pointerId;
      canvas.setPointerCapture(event.pointerId);
      stick.press(this.hand(event));
      this.hands.change();
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!stick.engaged || event.pointerId !== this.pointer) return;
      stick.move(this.hand(event));
      this.hands.change();
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault()); // a long press is a hold
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(end, (event) => {
        if (!stick.engaged || /** @type {PointerEvent} */ (event).pointerId !== this.pointer) return;
        stick.release();
        this.hands.change();
      });
    }
  }

  /** Returns the directions that are held back now.
   * @param {import("./types.js").Now} now
   * @param {number} full */
  cuts(now, full) {
    const decision = decisionInForce(now);
    if (!decision || this.axes.length < 2) return [];
    return cuts(now.held.filter(({ point }) => point === this.number), askedAndAllowed(decision, this.axes).allowed, full);
  }

  get reach() {
    return this.size / 2 - KNOB_PX - 3;
  }

  /** @param {PointerEvent} event
   * @returns {Pair} */
  hand(event) {
    const half = this.size / 2;
    const y = this.axes.length > 1 ? (half - event.offsetY) / this.reach : 0;
    return [(event.offsetX - half) / this.reach, y];
  }

  /** @param {import("./types.js").Now} now
   * @param {number} full
   * @param {Pair} value what steers, whichever source it comes from
   * @param {any} theme */
  draw(now, full, value, theme) {
    const rim = this.reach;
    const found = this.cuts(now, full);
    const [x, y] = inDisk(value);
    const angles = found.flatMap(({ angle, half }) => [angle * rim, half * rim]);
    if (!this.look.isNew([x * rim, y * rim, ...angles], [...this.drawn.frame, theme])) return;
    const pen = this.drawn.clear();
    /** @type {Pair} */
    const centre = [this.size / 2, this.size / 2];
    disk(pen, centre, this.size / 2 - 2, theme.sunken, theme.line);
    drawCuts(pen, centre, rim, found, theme.held);
    pen.strokeStyle = theme.line;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.arc(centre[0], centre[1], rim, 0, 2 * Math.PI);
    pen.moveTo(centre[0] - rim, centre[1]);
    pen.lineTo(centre[0] + rim, centre[1]);
    if (this.axes.length > 1) {
      pen.moveTo(centre[0], centre[1] - rim);
      pen.lineTo(centre[0], centre[1] + rim);
    }
    pen.stroke();
    disk(pen, [centre[0] + x * rim, centre[1] - y * rim], KNOB_PX, theme.accent, theme.raised);
  }
}

/** @param {CanvasRenderingContext2D} pen
 * @param {Pair} centre
 * @param {number} radius
 * @param {string} fill
 * @param {string} edge */
function disk(pen, centre, radius, fill, edge) {
  pen.beginPath();
  pen.arc(centre[0], centre[1], radius, 0, 2 * Math.PI);
  pen.fillStyle = fill;
  pen.fill();
  pen.lineWidth = 2;
  pen.strokeStyle = edge;
  pen.stroke();
}
