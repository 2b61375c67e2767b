// A stick without a home: where it is taken hold of is its centre, and a clutch lets the hand move without the command.

/** @typedef {import("./types.js").Pair} Pair */

/** Returns the nearest place in the unit disk.
 * @param {Pair} place
 * @returns {Pair} */
export function inDisk([x, y]) {
  const size = Math.hypot(x, y);
  return size > 1 ? [x / size, y / size] : [x, y];
}

/** Returns a deflection without its dead zone, continuous at its edge.
 * @param {Pair} place
 * @param {number} dead
 * @returns {Pair} */
export function withoutDeadZone([x, y], dead) {
  const size = Math.hypot(x, y);
  if (size <= dead) return [0, 0];
  const factor = Math.min((size - dead) / (1 - dead), 1) / size;
  return [x * factor, y * factor];
}

export class Stick {
  constructor() {
    this.engaged = false;
    this.clutched = false;
    /** @type {Pair} */
    this.value = [0, 0];
    /** @type {Pair} */
    this.hand = [0, 0];
    /** @type {Pair} */
    this.centre = [0, 0];
  }

  /** Takes hold of the stick: the command begins at zero wherever the hand is.
   * @param {Pair} hand in radii of the pad */
  press(hand) {
    this.engaged = true;
    this.hand = hand;
    this.centre = hand;
    this.value = [0, 0];
  }

  /** @param {Pair} hand */
  move(hand) {
    this.hand = hand;
    if (!this.engaged || this.clutched) return;
    this.value = inDisk([hand[0] - this.centre[0], hand[1] - this.centre[1]]);
  }

  /** Lets go: the command is zero at once. */
  release() {
    this.engaged = false;
    this.value = [0, 0];
  }

  /** Holds the command while the hand moves; afterwards the hand goes on from there without a jump.
   * @param {boolean} on */
  clutch(on) {
    if (this.clutched && !on) this.centre = [this.hand[0] - this.value[0], this.hand[1] - this.value[1]];
    this.clutched = on;
  }
}
