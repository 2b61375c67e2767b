// What a canvas shows now: a picture that would look the same is not drawn again.

const STEPS_PER_PX = 8;
const OLDEST_MS = 500;

export class ShownLook {
  constructor() {
    /** @type {number[]} */
    this.numbers = [];
    /** @type {unknown[]} */
    this.others = [];
    this.at = -Infinity;
  }

  /** Returns whether a picture looks other than the one that was drawn last, or that one has become old, and keeps its look.
   * @param {number[]} pixels places and lengths; angles as lengths
   * @param {unknown[]} others words, colours, sizes: whatever is to be the same
   * @param {number} [at] */
  isNew(pixels, others, at = performance.now()) {
    const numbers = pixels.map((value) => Math.round(STEPS_PER_PX * value));
    if (at - this.at < OLDEST_MS && isSame(numbers, this.numbers) && isSame(others, this.others)) return false;
    Object.assign(this, { numbers, others, at });
    return true;
  }
}

/** @param {unknown[]} now
 * @param {unknown[]} before */
function isSame(now, before) {
  return now.length === before.length && now.every((value, i) => Object.is(value, before[i]));
}
