// Signals of one run over plant time: every sample where the record has it, else lowest and highest of each bucket.

/** @typedef {{start_s: number, count: number, times: number, width_s?: number, low?: Object<string, number>,
 *   high?: Object<string, number>, first?: Object<string, number>, columns?: Object<string, number>}} Piece */

/** A bucket or sample: the piece that it is of, its number there, when it begins and ends.
 * @typedef {{piece: number, index: number, start: number, end: number}} Place */

/** A signal: its lowest and highest value at each place of the table's time axis.
 * @typedef {{low: Float32Array, high: Float32Array}} Envelope */

export class SignalTable {
  /** @param {{overview: Piece | null, blocks: Piece[]}} payload
   * @param {import("./unpack.js").PackedArrays} arrays
   * @param {number} offset seconds to add to every time, to lay one run over another */
  constructor(payload, arrays, offset = 0) {
    this.arrays = arrays;
    this.pieces = [...(payload.overview ? [payload.overview] : []), ...payload.blocks];
    this.width = payload.overview?.width_s ?? 0;
    /** @type {Map<string, Envelope>} */
    this.envelopes = new Map();
    this.places = this.placesOf(payload.blocks, offset);
    this.start = Float64Array.from(this.places, (place) => place.start);
    this.end = Float64Array.from(this.places, (place) => place.end);
    this.gap = 8 * this.usualStep() + this.width;
  }

  /** Returns buckets and samples in order of time; buckets that samples cover are left out.
   * @param {Piece[]} blocks
   * @param {number} offset */
  placesOf(blocks, offset) {
    /** @type {[number, number][]} */
    const spans = [];
    /** @type {Place[]} */
    const places = [];
    this.pieces.forEach((piece, number) => {
      const times = this.arrays.times(piece.times, piece.count, piece.start_s + offset);
      const width = piece.width_s ?? 0;
      if (blocks.includes(piece)) spans.push([times[0], times[times.length - 1]]);
      times.forEach((start, index) => places.push({ piece: number, index, start, end: start + width }));
    });
    const covered = (/** @type {Place} */ place) => place.end > place.start && spans.some(([a, b]) => a <= place.start && place.end <= b);
    return places.filter((place) => !covered(place)).sort((a, b) => a.start - b.start);
  }

  usualStep() {
    const steps = [];
    for (let i = 1; i < this.start.length; i += 1) steps.push(this.start[i] - this.end[i - 1]);
    steps.sort((a, b) => a - b);
    return Math.max(steps[steps.length >> 1] ?? 0, 1e-3);
  }

  /** @param {string} column */
  has(column) {
    return this.pieces.some((piece) => column in (piece.columns ?? {}) || column in (piece.first ?? piece.low ?? {}));
  }

  /** @param {string} column
   * @returns {Envelope} */
  envelope(column) {
    const held = this.envelopes.get(column);
    if (held) return held;
    const read = this.pieces.map((piece) => this.read(piece, column));
    const low = Float32Array.from(this.places, ({ piece, index }) => read[piece].low[index]);
    const high = Float32Array.from(this.places, ({ piece, index }) => read[piece].high[index]);
    const made = { low, high };
    this.envelopes.set(column, made);
    return made;
  }

  /** @param {Piece} piece
   * @param {string} column
   * @returns {Envelope} */
  read(piece, column) {
    const one = piece.columns?.[column] ?? piece.first?.[column];
    if (one !== undefined) {
      const values = this.arrays.floats(one, piece.count);
      return { low: values, high: values };
    }
    const [low, high] = [piece.low?.[column], piece.high?.[column]];
    if (low === undefined || high === undefined) {
      const nothing = new Float32Array(piece.count).fill(Number.NaN);
      return { low: nothing, high: nothing };
    }
    return { low: this.arrays.floats(low, piece.count), high: this.arrays.floats(high, piece.count) };
  }

  /** Returns the place of the last sample or bucket that began at or before `time`; −1 before all.
   * @param {number} time */
  at(time) {
    let [low, high] = [0, this.start.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.start[middle] <= time + 1e-9) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  /** Returns lowest and highest value at a time; null where there is none.
   * @param {string} column
   * @param {number} time
   * @returns {[number, number] | null} */
  range(column, time) {
    const place = this.at(time);
    if (place < 0 || time > this.end[place] + this.gap) return null;
    const { low, high } = this.envelope(column);
    return Number.isNaN(low[place]) ? null : [low[place], high[place]];
  }

  /** Returns the value at a time on the straight line between samples; null where there is none.
   * @param {string} column
   * @param {number} time */
  value(column, time) {
    const { low } = this.envelope(column);
    const place = Math.max(this.at(time), 0);
    if (!(place < low.length)) return null;
    const next = Math.min(place + 1, low.length - 1);
    const step = this.start[next] - this.start[place];
    const share = step > 0 && step <= 2 * this.gap ? Math.min(Math.max((time - this.start[place]) / step, 0), 1) : 0;
    const value = low[place] + share * (low[next] - low[place]);
    return Number.isNaN(value) ? null : value;
  }
}
