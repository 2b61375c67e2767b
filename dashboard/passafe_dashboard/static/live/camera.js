// The part of the plane in view: the scenario's bounds, widened while a robot is outside of them.

/** @typedef {import("./types.js").Pair} Pair */

/** Room around the bounds, pixels: the dial of inputs of a robot at a wall is in view. */
export const MARGIN_PX = 58;
const EASE = 0.2;
const LEAST_SPAN = 0.1;

/** Returns bounds that also hold some places.
 * @param {[Pair, Pair]} bounds lowest and highest corner
 * @param {Pair[]} places
 * @returns {[Pair, Pair]} */
export function widened([low, high], places) {
  /** @param {0 | 1} axis */
  const least = (axis) => Math.min(low[axis], ...places.map((place) => place[axis]));
  /** @param {0 | 1} axis */
  const most = (axis) => Math.max(high[axis], ...places.map((place) => place[axis]));
  return [
    [least(0), least(1)],
    [most(0), most(1)],
  ];
}

export class Camera {
  /** @param {[Pair, Pair]} bounds */
  constructor(bounds) {
    this.bounds = bounds;
    this.width = 1;
    this.height = 1;
    this.scale = 1;
    /** @type {Pair} */
    this.centre = [0, 0];
    this.settled = false;
  }

  /** Aims at the bounds and the places; returns whether the view has changed.
   * @param {number} width of the picture, pixels
   * @param {number} height
   * @param {Pair[]} places that must be in view */
  aim(width, height, places) {
    const [low, high] = widened(this.bounds, places);
    const room = Math.min(MARGIN_PX, width / 5, height / 5);
    /** @param {0 | 1} axis */
    const span = (axis) => Math.max(high[axis] - low[axis], LEAST_SPAN);
    const scale = Math.min((width - 2 * room) / span(0), (height - 2 * room) / span(1));
    /** @type {Pair} */
    const centre = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    const resized = width !== this.width || height !== this.height || !this.settled;
    const ease = resized ? 1 : EASE;
    const before = [this.scale, ...this.centre];
    Object.assign(this, { width, height, settled: true });
    this.scale += ease * (scale - this.scale);
    this.centre = [this.centre[0] + ease * (centre[0] - this.centre[0]), this.centre[1] + ease * (centre[1] - this.centre[1])];
    const now = [this.scale, ...this.centre];
    return resized || now.some((value, i) => Math.abs(value - before[i]) > 1e-4 * Math.max(Math.abs(value), 1 / this.scale));
  }

  /** Returns the pixel of a place.
   * @param {number} x
   * @param {number} y
   * @returns {Pair} */
  pixel(x, y) {
    return [this.width / 2 + (x - this.centre[0]) * this.scale, this.height / 2 - (y - this.centre[1]) * this.scale];
  }

  /** Returns lowest and highest corner in view.
   * @returns {[Pair, Pair]} */
  get view() {
    const [w, h] = [this.width / 2 / this.scale, this.height / 2 / this.scale];
    return [
      [this.centre[0] - w, this.centre[1] - h],
      [this.centre[0] + w, this.centre[1] + h],
    ];
  }
}
