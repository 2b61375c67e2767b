// Keys that steer: a held key pushes further and further, a released one lets go at once.

/** @typedef {import("./types.js").Pair} Pair */

const RATE_PER_S = 3;

/** @type {Record<string, [number, Pair]>} group of keys and direction */
const DIRECTIONS = {
  ArrowRight: [0, [1, 0]],
  ArrowLeft: [0, [-1, 0]],
  ArrowUp: [0, [0, 1]],
  ArrowDown: [0, [0, -1]],
  KeyD: [1, [1, 0]],
  KeyA: [1, [-1, 0]],
  KeyW: [1, [0, 1]],
  KeyS: [1, [0, -1]],
};

export class SteeringKeys {
  /** @param {number} pads number of planes to steer; with one, both groups of keys steer it */
  constructor(pads) {
    this.pads = pads;
    /** @type {Set<string>} */
    this.held = new Set();
    /** @type {Pair[]} */
    this.values = Array.from({ length: pads }, () => [0, 0]);
  }

  /** Returns whether a key steers.
   * @param {string} code */
  static steers(code) {
    return code in DIRECTIONS;
  }

  get engaged() {
    return this.held.size > 0;
  }

  /** @param {string} code
   * @param {boolean} down */
  set(code, down) {
    if (!SteeringKeys.steers(code)) return;
    if (down) this.held.add(code);
    else this.held.delete(code);
  }

  releaseAll() {
    this.held.clear();
    this.values = this.values.map(() => [0, 0]);
  }

  /** Moves the values towards what the keys ask for.
   * @param {number} dt_s
   * @param {boolean} clutched whether they stay as they are */
  step(dt_s, clutched = false) {
    if (clutched && this.engaged) return;
    this.values = this.values.map((value, pad) => {
      const target = this.target(pad);
      return /** @type {Pair} */ (value.map((now, axis) => approach(now, target[axis], RATE_PER_S * dt_s)));
    });
  }

  /** @param {number} pad
   * @returns {Pair} */
  target(pad) {
    const sum = [0, 0];
    for (const code of this.held) {
      const [group, [x, y]] = DIRECTIONS[code];
      if (Math.min(group, this.pads - 1) !== pad) continue;
      sum[0] += x;
      sum[1] += y;
    }
    const size = Math.max(Math.hypot(sum[0], sum[1]), 1);
    return [sum[0] / size, sum[1] / size];
  }
}

/** Returns a value nearer to a target; towards zero, or past it, it goes at once.
 * @param {number} now
 * @param {number} target
 * @param {number} step */
function approach(now, target, step) {
  if (target === 0 || now * target < 0) return target === 0 ? 0 : Math.sign(target) * Math.min(step, Math.abs(target));
  return now + Math.sign(target - now) * Math.min(step, Math.abs(target - now));
}
