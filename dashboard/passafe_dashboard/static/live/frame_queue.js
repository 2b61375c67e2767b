// Frames that were received and not drawn yet, as one: a page that draws late draws the newest state and all rows.

/** @typedef {import("./types.js").Frame} Frame */

export class FrameQueue {
  /** @param {number} rows most rows that are kept of a table */
  constructor(rows) {
    this.rows = rows;
    this.restart = false;
    this.lost = 0;
    /** @type {Frame["tables"]} */
    this.tables = { ticks: [], states: [] };
    /** @type {Frame["now"] | null} */
    this.now = null;
  }

  clear() {
    Object.assign(this, { restart: false, lost: 0, tables: { ticks: [], states: [] }, now: null });
  }

  /** @param {Frame} frame */
  add(frame) {
    if (frame.restart) {
      this.clear();
      this.restart = true;
    }
    for (const name of /** @type {const} */ (["ticks", "states"])) {
      const kept = this.tables[name];
      kept.push(...frame.tables[name]);
      kept.splice(0, Math.max(kept.length - this.rows, 0));
    }
    this.lost += frame.lost;
    this.now = frame.now;
  }

  /** Returns what waits and forgets it; null if nothing does. */
  take() {
    if (!this.now) return null;
    const { restart, tables, lost, now } = this;
    this.clear();
    return { restart, tables, lost, now };
  }
}
