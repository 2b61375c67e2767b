// Draws signals over time: a line through samples, a shaded band from lowest to highest where there are only buckets.

/** Place of a plot in its canvas, CSS pixels.
 * @typedef {{left: number, top: number, width: number, height: number}} Box */

/** @typedef {{table: import("./payload.js").Table, column: string, colour: string, dash: number[],
 *   width: number, alpha: number}} Stroke */

const WIDE = 3;

/** Returns lowest and highest value of signals in view.
 * @param {Stroke[]} strokes
 * @param {import("./time_view.js").TimeView} view
 * @returns {[number, number]} */
export function extent(strokes, view) {
  let [low, high] = [Infinity, -Infinity];
  for (const { table, column } of strokes) {
    const values = table.envelope(column);
    const last = table.at(view.to);
    for (let i = Math.max(table.at(view.from), 0); i <= last; i += 1) {
      if (values.low[i] < low) low = values.low[i];
      if (values.high[i] > high) high = values.high[i];
    }
  }
  return [low, high];
}

/** @param {CanvasRenderingContext2D} pen
 * @param {Box} box
 * @param {import("./time_view.js").TimeView} view
 * @param {{share: (value: number) => number}} axis
 * @param {Stroke} stroke */
export function drawStroke(pen, box, view, axis, stroke) {
  const { table, column } = stroke;
  const { low, high } = table.envelope(column);
  const scale = box.width / (view.to - view.from);
  const x = (/** @type {number} */ time) => box.left + (time - view.from) * scale;
  const y = (/** @type {number} */ value) => box.top + box.height * (1 - Math.min(Math.max(axis.share(value), -0.5), 1.5));
  const last = Math.min(table.at(view.to) + 1, low.length - 1);
  pen.strokeStyle = stroke.colour;
  pen.fillStyle = stroke.colour;
  pen.lineWidth = stroke.width;
  pen.globalAlpha = stroke.alpha;
  pen.setLineDash(stroke.dash);
  pen.lineJoin = "round";
  pen.beginPath();
  let down = false;
  let ended = -Infinity;
  for (let i = Math.max(table.at(view.from), 0); i <= last; i += 1) {
    if (Number.isNaN(low[i]) || table.start[i] - ended > table.gap) down = false;
    ended = table.end[i];
    if (Number.isNaN(low[i])) continue;
    const [from, to] = [x(table.start[i]), x(table.end[i])];
    const [bottom, top] = [y(low[i]), y(high[i])];
    if (to - from > WIDE && bottom - top > 1) {
      down = false;
      shade(pen, from, top, to - from, bottom - top, stroke.alpha);
      continue;
    }
    const middle = (from + to) / 2;
    if (down) pen.lineTo(middle, bottom);
    else pen.moveTo(middle, bottom);
    if (bottom - top > 0.5) pen.lineTo(middle, top);
    down = true;
  }
  pen.stroke();
  pen.setLineDash([]);
  pen.globalAlpha = 1;
}

/** Shades a bucket that is wide in view, of which only lowest and highest value are known.
 * @param {CanvasRenderingContext2D} pen
 * @param {number} left
 * @param {number} top
 * @param {number} width
 * @param {number} height
 * @param {number} alpha */
function shade(pen, left, top, width, height, alpha) {
  pen.globalAlpha = 0.3 * alpha;
  pen.fillRect(left, top, width, height);
  pen.globalAlpha = alpha;
  pen.moveTo(left, top);
  pen.lineTo(left + width, top);
  pen.moveTo(left, top + height);
  pen.lineTo(left + width, top + height);
}
