// Axes: where values lie on a plot, and which of them are written beside it.

import { numberText } from "./number_text.js";

const STEPS = [1, 2, 5, 10];

/** Returns the round step that gives about `count` of them in a span.
 * @param {number} span
 * @param {number} count */
export function roundStep(span, count) {
  const rough = span / Math.max(count, 1);
  const decade = 10 ** Math.floor(Math.log10(rough));
  return (STEPS.find((step) => step * decade >= rough) ?? 10) * decade;
}

/** @param {number} low
 * @param {number} high
 * @param {number} step */
export function multiples(low, high, step) {
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k += 1) found.push(k * step || 0);
  return found;
}

/** Returns a multiple of a step as text, with as many places as the step has.
 * @param {number} value
 * @param {number} step */
export function tickText(value, step) {
  const size = Math.max(Math.abs(value), step);
  if (size >= 1e5 || step < 1e-4) return numberText(value, Math.max(2, Math.ceil(Math.log10(size / step) + 1)));
  return value.toFixed(Math.max(Math.ceil(-Math.log10(step) - 1e-9), 0)).replace("-", "−");
}

/** A linear axis of values. */
export class LinearAxis {
  /** @param {number} low
   * @param {number} high
   * @param {{zero: boolean, least_span: number}} plan */
  constructor(low, high, plan) {
    let [a, b] = Number.isFinite(low) ? [low, high] : [0, 0];
    if (plan.zero) [a, b] = [Math.min(a, 0), Math.max(b, 0)];
    const lacking = Math.max(plan.least_span, 1e-12 * Math.max(Math.abs(a), Math.abs(b))) - (b - a);
    if (lacking > 0) [a, b] = [a - lacking / 2, b + lacking / 2];
    const margin = 0.06 * (b - a);
    this.low = a - margin;
    this.high = b + margin;
  }

  /** Returns the share of the axis below a value.
   * @param {number} value */
  share(value) {
    return (value - this.low) / (this.high - this.low);
  }

  /** @param {number} count
   * @returns {[number, string][]} */
  ticks(count) {
    const step = roundStep(this.high - this.low, count);
    return multiples(this.low, this.high, step).map((value) => [value, tickText(value, step)]);
  }
}

/** An axis that is linear around 0 and logarithmic far from it; of values that are small in view it shows two decades. */
export class SignedLogAxis {
  /** @param {number} low
   * @param {number} high
   * @param {{linear: number}} plan */
  constructor(low, high, plan) {
    const largest = Math.max(Math.abs(low), Math.abs(high));
    this.linear = largest > 0 && largest < 100 * plan.linear ? 10 ** Math.floor(Math.log10(largest / 100)) : plan.linear;
    const [a, b] = Number.isFinite(low) ? [Math.min(low, 0), Math.max(high, 0)] : [0, 0];
    const [below, above] = [Math.asinh(a / this.linear), Math.asinh(b / this.linear)];
    const margin = 0.06 * Math.max(above - below, 1);
    this.low = below - margin;
    this.high = above + margin;
  }

  /** @param {number} value */
  share(value) {
    return (Math.asinh(value / this.linear) - this.low) / (this.high - this.low);
  }

  /** @param {number} count
   * @returns {[number, string][]} */
  ticks(count) {
    const found = [0];
    const decades = Math.max(Math.abs(this.low), Math.abs(this.high)) / Math.LN10;
    const stride = Math.max(1, Math.ceil((this.high - this.low) / Math.LN10 / Math.max(count, 1)));
    for (let k = 0; k <= decades; k += stride) {
      for (const sign of [-1, 1]) {
        const value = sign * this.linear * 10 ** k;
        const share = this.share(value);
        if (share > 0.02 && share < 0.98) found.push(value);
      }
    }
    const away = found.filter((value) => value === 0 || Math.abs(this.share(value) - this.share(0)) > 0.08);
    return away.sort((a, b) => a - b).map((value) => [value, numberText(value, 2)]);
  }
}
