// The words for the driver: what holds the robot now, and why.

import { byId, setText } from "./elements.js";

/** @param {import("./types.js").Words} words */
export function showWords({ tone, headline, detail }) {
  byId("words").dataset.tone = tone;
  setText(byId("headline"), headline);
  setText(byId("detail"), detail);
}
