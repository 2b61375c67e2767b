// The cursor and the stretch of time in view, which all plots share.

const LEAST_SPAN = 0.002;

export class TimeView extends EventTarget {
  /** @param {number} start
   * @param {number} end */
  constructor(start, end) {
    super();
    this.start = start;
    this.end = Math.max(end, start + LEAST_SPAN);
    this.from = this.start;
    this.to = this.end;
    this.cursor = this.start;
  }

  /** @param {number} time */
  moveCursor(time) {
    this.cursor = Math.min(Math.max(time, this.start), this.end);
    this.dispatchEvent(new Event("cursor"));
  }

  /** Shows a stretch; what lies outside of the run is cut off.
   * @param {number} from
   * @param {number} to */
  show(from, to) {
    const span = Math.min(Math.max(to - from, LEAST_SPAN), this.end - this.start);
    this.from = Math.min(Math.max(from, this.start), this.end - span);
    this.to = this.from + span;
    this.dispatchEvent(new Event("window"));
  }

  showAll() {
    this.show(this.start, this.end);
  }

  /** Shows `factor` times as much, around a time that stays where it is.
   * @param {number} factor
   * @param {number} time */
  zoom(factor, time = this.cursor) {
    const around = time >= this.from && time <= this.to ? time : (this.from + this.to) / 2;
    const span = (this.to - this.from) * factor;
    const share = (around - this.from) / (this.to - this.from);
    this.show(around - share * span, around + (1 - share) * span);
  }

  /** @param {number} share of the stretch in view */
  pan(share) {
    const step = (this.to - this.from) * share;
    this.show(this.from + step, this.to + step);
  }

  /** Puts the cursor at a time and shows what is around it.
   * @param {number} time
   * @param {number} span */
  jump(time, span) {
    this.show(time - span / 2, time + span / 2);
    this.moveCursor(time);
  }
}
