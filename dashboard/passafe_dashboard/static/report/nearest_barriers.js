// The barriers nearest to being violated at the cursor, one bar each, the nearest first.

import { rangeText } from "./number_text.js";

const MOST = 5;

export class NearestBarriers {
  /** @param {HTMLElement} list
   * @param {import("./payload.js").ChartPlan} plan of the chart of barriers
   * @param {import("./payload.js").Run} run */
  constructor(list, plan, run) {
    this.list = list;
    this.lines = plan.lines;
    this.table = run.tables.states;
    this.rows = this.lines.slice(0, MOST).map(() => this.row());
    list.append(...this.rows.map(({ item }) => item));
    this.scale = this.lines.map(({ column }) => largest(this.table.envelope(column).high));
  }

  row() {
    const item = document.createElement("li");
    const [name, bar, value] = ["name", "bar", "value"].map((kind) =>
      Object.assign(document.createElement("span"), { className: kind }),
    );
    const fill = document.createElement("span");
    bar.append(fill);
    item.append(name, bar, value);
    return { item, name, fill, value };
  }

  /** @param {number} time */
  read(time) {
    const known = this.lines.flatMap((line, i) => {
      const range = this.table.range(line.column, time);
      return range ? [{ line, range, scale: this.scale[i] }] : [];
    });
    known.sort((a, b) => a.range[0] - b.range[0]);
    this.rows.forEach((row, i) => {
      const found = known[i];
      row.item.hidden = !found;
      if (!found) return;
      const violated = found.range[0] < 0;
      row.item.className = violated ? "violated" : "";
      row.name.textContent = violated ? `${found.line.label}: violated` : found.line.label;
      row.fill.style.width = `${100 * Math.min(Math.max(found.range[0] / found.scale, 0), 1)}%`;
      row.value.textContent = `${rangeText(found.range)} ${found.line.unit}`;
    });
  }
}

/** @param {Float32Array} values */
function largest(values) {
  let most = 1e-9;
  for (const value of values) if (value > most) most = value;
  return most;
}
