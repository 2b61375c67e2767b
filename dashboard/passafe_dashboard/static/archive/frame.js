// The frame of every page of logs and experiments: how high its bar is, and beside a robot what it does, and its stop.

import { GamepadReader } from "../live/gamepad.js";
import { StopButton } from "../stop_button.js";
import { showRobot } from "./robot_line.js";

const LOOK_MS = 1000;
const ANSWER_MS = 3000;
const GAMEPAD_MS = 50;

const bar = /** @type {HTMLElement} */ (document.querySelector("header.bar"));
new ResizeObserver(() => document.documentElement.style.setProperty("--frame", `${bar.offsetHeight}px`)).observe(bar);

/** Shows the robot's state again and again while the page is in sight.
 * @param {StopButton} stop
 * @param {HTMLElement} line */
async function follow(stop, line) {
  if (!document.hidden) {
    const state = await robotState();
    showRobot(line, state);
    if (state) stop.show(state.stop);
  }
  setTimeout(() => follow(stop, line), LOOK_MS);
}

/** Returns the state of the running system; null without an answer.
 * @returns {Promise<any>} */
async function robotState() {
  try {
    const response = await fetch("/api/status", { signal: AbortSignal.timeout(ANSWER_MS) });
    return response.ok ? await response.json() : null;
  } catch {
    return null;
  }
}

/** Presses the stop when a gamepad's button for it is pressed.
 * @param {StopButton} stop
 * @param {GamepadReader} gamepad */
function readGamepad(stop, gamepad) {
  if (gamepad.read(navigator.getGamepads?.() ?? [], 1).stop) stop.stop();
}

const line = document.getElementById("robot");
if (line) {
  const stop = new StopButton(document);
  follow(stop, line);
  const gamepad = new GamepadReader();
  setInterval(() => readGamepad(stop, gamepad), GAMEPAD_MS);
}
