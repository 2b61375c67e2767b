// The frame of every page of logs and experiments: how high its bar is, and the emergency stop beside a robot.

import { StopButton } from "../stop_button.js";

const LOOK_MS = 3000;

const bar = /** @type {HTMLElement} */ (document.querySelector("header.bar"));
new ResizeObserver(() => document.documentElement.style.setProperty("--frame", `${bar.offsetHeight}px`)).observe(bar);

if (document.getElementById("stop")) {
  const stop = new StopButton(document);
  const look = () => {
    if (!document.hidden) stop.follow();
  };
  look();
  setInterval(look, LOOK_MS);
}
