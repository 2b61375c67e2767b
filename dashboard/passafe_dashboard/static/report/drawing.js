// A canvas made ready for drawing, and lines on it.

/** @typedef {CanvasRenderingContext2D} Pen */

/** Returns the pen of a canvas that has this size now.
 * @param {HTMLCanvasElement} canvas
 * @param {number} width
 * @param {number} height */
export function prepare(canvas, width, height) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = `${height}px`;
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return pen;
}

/** Draws a line through places, CSS pixels.
 * @param {Pen} pen
 * @param {import("./payload.js").Pair[]} places
 * @param {string} colour
 * @param {number} width
 * @param {number[]} dash */
export function line(pen, places, colour, width = 1, dash = []) {
  pen.beginPath();
  for (const [x, y] of places) pen.lineTo(x, y);
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.setLineDash(dash);
  pen.stroke();
  pen.setLineDash([]);
}
