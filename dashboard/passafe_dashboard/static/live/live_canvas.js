// A canvas that is drawn again and again: its size without asking for a layout each time, and a pen on it.

/** Radius of the corners of a scene, pixels. A clip by style sheet costs the compositor of a browser without a graphics
 * processor about a fifth of its time. */
export const CORNER_PX = 8;

export class LiveCanvas {
  /** @param {HTMLCanvasElement} canvas
   * @param {[number, number]} [size] pixels; if not given, that of the page's layout */
  constructor(canvas, size) {
    this.canvas = canvas;
    this.width = size?.[0] ?? 0;
    this.height = size?.[1] ?? 0;
    if (!size) new ResizeObserver(() => this.measure()).observe(canvas);
  }

  measure() {
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
  }

  /** Returns size and density, of which a picture depends. */
  get frame() {
    return [this.width, this.height, window.devicePixelRatio || 1];
  }

  /** Returns a pen on the empty canvas.
   * @returns {CanvasRenderingContext2D} */
  clear() {
    const [width, height, ratio] = this.frame;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
    const pen = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    return pen;
  }
}
