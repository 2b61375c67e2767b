// One bar for each barrier: the distance that is left, against zero; the nearest is marked.

import { byId, element, setAttribute, setText } from "./elements.js";

/** @typedef {import("./types.js").Gap} Gap */

const FULL = { m: 1, "m/s": 1, rad: 1, "rad/s": 1 };
const BEYOND_SHARE = 0.15;
export const MOST = 10;

/** Returns the bars to draw: those of all barriers, or of the nearest where there are very many.
 * @param {Gap[]} gaps in the scenario's order
 * @param {number} [most] */
export function shownGaps(gaps, most = MOST) {
  if (gaps.length <= most) return gaps;
  const limit = [...gaps].map(({ distance }) => distance).sort((a, b) => a - b)[most - 1];
  return gaps.filter(({ distance }) => distance <= limit).slice(0, most);
}

/** Returns begin and length of a bar as shares of its track, whose zero lies at `zero`.
 * Near the limit a centimetre counts more than far from it: the length goes with the root of the distance.
 * @param {Gap} gap
 * @param {number} zero */
export function barSpan(gap, zero) {
  const full = FULL[/** @type {keyof typeof FULL} */ (gap.unit)] ?? 1;
  const share = Math.min(Math.sqrt(Math.abs(gap.distance) / full / 2), 1);
  if (gap.distance >= 0) return { begin: zero, length: (1 - zero) * share };
  const length = zero * Math.max(share, 0.3);
  return { begin: zero - length, length };
}

export class GapBars {
  constructor() {
    /** @type {{item: HTMLElement, name: HTMLElement, track: HTMLElement, fill: HTMLElement, value: HTMLElement}[]} */
    this.rows = [];
  }

  /** @param {Gap[]} gaps */
  show(gaps) {
    const shown = shownGaps(gaps);
    const list = byId("gaps");
    setText(byId("gaps-shown"), shown.length < gaps.length ? `nearest ${shown.length} of ${gaps.length}` : "");
    while (this.rows.length < shown.length) this.rows.push(row(list));
    const zero = BEYOND_SHARE;
    this.rows.forEach((each, i) => {
      const gap = shown[i];
      each.item.hidden = !gap;
      if (!gap) return;
      const violated = gap.distance < 0;
      setAttribute(each.item, "class", [gap.nearest ? "nearest" : "", violated ? "violated" : ""].join(" ").trim());
      setText(each.name, gap.name);
      setAttribute(each.name, "title", gap.name);
      setText(each.value, gap.text);
      const { begin, length } = barSpan(gap, zero);
      each.track.style.setProperty("--zero", `${100 * zero}%`);
      each.fill.style.left = `${(100 * begin).toFixed(1)}%`;
      each.fill.style.width = `${(100 * length).toFixed(1)}%`;
    });
  }
}

/** @param {HTMLElement} list */
function row(list) {
  const item = element("li");
  const [name, track, value] = ["name", "track", "value"].map((kind) => element("span", kind));
  const fill = element("span", "fill");
  track.append(fill);
  item.append(name, track, value);
  list.append(item);
  return { item, name, track, fill, value };
}
