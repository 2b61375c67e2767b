// The newest rows of a table over plant time, read like the signals of a finished run.

import { SignalTable } from "../report/signal_table.js";

const GAP_S = 0.4;

/** Rows are written one behind the other into arrays with room for twice the capacity, so that only the new ones are
 * touched; when the end is reached, those that are kept move to the begin. */
export class LiveTable extends SignalTable {
  /** @param {string[]} columns names of the values of a row; the first two are begin and end of its time
   * @param {number} capacity rows kept */
  constructor(columns, capacity) {
    super({ overview: null, blocks: [] }, /** @type {any} */ (null));
    this.columns = columns;
    this.capacity = capacity;
    this.gap = GAP_S;
    this.begins = new Float64Array(2 * capacity);
    this.ends = new Float64Array(2 * capacity);
    this.values = columns.slice(2).map(() => new Float32Array(2 * capacity));
    this.first = 0;
    this.last = 0;
    this.index();
  }

  clear() {
    this.first = this.last = 0;
    this.index();
  }

  /** @param {(number | null)[][]} rows */
  push(rows) {
    if (!rows.length) return;
    for (const row of rows.slice(-this.capacity)) this.write(row);
    this.first = Math.max(this.last - this.capacity, 0);
    this.index();
  }

  /** @param {(number | null)[]} row */
  write(row) {
    if (this.last === this.begins.length) this.moveToBegin();
    this.begins[this.last] = row[0] ?? Number.NaN;
    this.ends[this.last] = row[1] ?? Number.NaN;
    this.values.forEach((column, i) => {
      column[this.last] = row[i + 2] ?? Number.NaN;
    });
    this.last += 1;
  }

  moveToBegin() {
    const from = this.last - this.capacity;
    for (const array of [this.begins, this.ends, ...this.values]) array.copyWithin(0, from, this.last);
    this.last = this.capacity;
  }

  index() {
    this.start = this.begins.subarray(this.first, this.last);
    this.end = this.ends.subarray(this.first, this.last);
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
    const values = index < 2 ? this.begunOf(index) : this.values[index - 2].subarray(this.first, this.last);
    const made = { low: values, high: values };
    this.envelopes.set(column, made);
    return made;
  }

  /** Returns the times as values; NaN for a column that there is not.
   * @param {number} index */
  begunOf(index) {
    if (index < 0) return new Float32Array(this.start.length).fill(Number.NaN);
    return Float32Array.from(index ? this.end : this.start);
  }

  /** Returns the time of the newest row; NaN without one. */
  get newest() {
    return this.end[this.end.length - 1] ?? Number.NaN;
  }
}
