// The words for the driver: what holds the robot now, and why.

import { byId, setText } from "./elements.js";

/** Words in the place of the filter's where a hold of this page was lost. */
export const HOLD_LOST = {
  tone: "guard",
  headline: "Your hold was lost: let go and press again",
  detail: "This page or its network paused for more than a quarter of a second. Nothing is asked of the robot meanwhile.",
};

/** @param {import("./types.js").Words} words */
export function showWords({ tone, headline, detail }) {
  byId("words").dataset.tone = tone;
  setText(byId("headline"), headline);
  setText(byId("detail"), detail);
}
