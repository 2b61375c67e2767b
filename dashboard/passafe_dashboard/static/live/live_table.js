// The newest rows of a table over plant time, read like the signals of a finished run.

import { SignalTable } from "../report/signal_table.js";

const GAP_S = 0.4;

export class LiveTable extends SignalTable {
  /** @param {string[]} columns names of the values of a row; the first two are begin and end of its time
   * @param {number} capacity rows kept */
  constructor(columns, capacity) {
    super({ overview: null, blocks: [] }, /** @type {any} */ (null));
    this.columns = columns;
    this.capacity = capacity;
    /** @type {(number | null)[][]} */
    this.kept = [];
    this.gap = GAP_S;
    this.start = new Float64Array();
    this.end = new Float64Array();
  }

  clear() {
    this.kept = [];
    this.index();
  }

  /** @param {(number | null)[][]} rows */
  push(rows) {
    if (!rows.length) return;
    this.kept.push(...rows);
    this.kept.splice(0, Math.max(this.kept.length - this.capacity, 0));
    this.index();
  }

  index() {
    this.start = Float64Array.from(this.kept, (row) => row[0] ?? Number.NaN);
    this.end = Float64Array.from(this.kept, (row) => row[1] ?? Number.NaN);
    this.envelopes.clear();
  }

  /** @param {string} column */
  has(column) {
    return this.columns.includes(column);
  }

  /** @param {string} column */
  envelope(column) {
    const held = this.envelopes.get(column);
    if (held) return held;
    const index = this.columns.indexOf(column);
    const values = Float32Array.from(this.kept, (row) => row[index] ?? Number.NaN);
    const made = { low: values, high: values };
    this.envelopes.set(column, made);
    return made;
  }

  /** Returns the time of the newest row; NaN without one. */
  get newest() {
    return this.end[this.end.length - 1] ?? Number.NaN;
  }
}
