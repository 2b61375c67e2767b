// The words for the driver: what holds the robot now, and why.

import { byId, setText } from "./elements.js";

const HOLD_MS = 400;

export class WordsPanel {
  constructor() {
    this.shownAt = -Infinity;
    this.tone = "";
  }

  /** Shows words; those of a milder or equal tone wait until the ones before could be read.
   * @param {import("./types.js").Words} words
   * @param {number} at milliseconds */
  show(words, at) {
    if (words.tone === this.tone && at - this.shownAt < HOLD_MS) return;
    if (words.tone === "free" && this.tone !== "free" && at - this.shownAt < HOLD_MS) return;
    this.shownAt = at;
    this.tone = words.tone;
    byId("words").dataset.tone = words.tone;
    setText(byId("headline"), words.headline);
    setText(byId("detail"), words.detail);
  }
}
