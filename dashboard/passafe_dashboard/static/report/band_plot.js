// Draws bands over time: the worst status of each pixel, or where a row of the filter's program was active.

/** Calls back for every stretch of equal, known values in view, with the highest value of each pixel.
 * @param {import("./payload.js").Table} table
 * @param {string} column
 * @param {import("./line_plot.js").Box} box
 * @param {import("./time_view.js").TimeView} view
 * @param {(left: number, width: number, low: number, high: number) => void} draw */
export function eachStretch(table, column, box, view, draw) {
  const { low, high } = table.envelope(column);
  const scale = box.width / (view.to - view.from);
  const columns = Math.ceil(box.width);
  const lowest = new Float32Array(columns).fill(Infinity);
  const highest = new Float32Array(columns).fill(-Infinity);
  const last = table.at(view.to);
  for (let i = Math.max(table.at(view.from), 0); i <= last; i += 1) {
    if (Number.isNaN(high[i])) continue;
    const next = i + 1 < table.start.length ? table.start[i + 1] : table.end[i];
    const end = next - table.end[i] > table.gap ? table.end[i] : Math.max(next, table.end[i]);
    const first = Math.max(Math.floor((table.start[i] - view.from) * scale), 0);
    const final = Math.min(Math.max(Math.ceil((end - view.from) * scale) - 1, first), columns - 1);
    for (let pixel = first; pixel <= final; pixel += 1) {
      if (low[i] < lowest[pixel]) lowest[pixel] = low[i];
      if (high[i] > highest[pixel]) highest[pixel] = high[i];
    }
  }
  for (let begin = 0, pixel = 1; pixel <= columns; pixel += 1) {
    if (pixel < columns && lowest[pixel] === lowest[begin] && highest[pixel] === highest[begin]) continue;
    if (highest[begin] > -Infinity) draw(box.left + begin, pixel - begin, lowest[begin], highest[begin]);
    begin = pixel;
  }
}

/** @param {CanvasRenderingContext2D} pen
 * @param {string} text
 * @param {number} left
 * @param {number} middle
 * @param {{ink: string, paper: string}} colours */
export function haloText(pen, text, left, middle, colours) {
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  pen.lineJoin = "round";
  pen.lineWidth = 3;
  pen.strokeStyle = colours.paper;
  pen.strokeText(text, left, middle);
  pen.fillStyle = colours.ink;
  pen.fillText(text, left, middle);
}
