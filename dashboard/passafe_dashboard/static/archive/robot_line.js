// What the robot does now, in one line of the frame: whoever reads a log sees that it runs, is held back, or stands.

/** @typedef {{tone: string, headline: string, detail: string}} Words live/driver_words.py */

const SILENT = {
  tone: "broken",
  headline: "The dashboard does not answer",
  detail: "What the robot does is not known here. Use passafe stop, or the robot's own switch.",
};

/** Returns the words of a state; those of silence without one.
 * @param {{words: Words} | null} state the answer of /api/status */
export function robotWords(state) {
  return state?.words ?? SILENT;
}

/** Writes the words into the frame.
 * @param {HTMLElement} line
 * @param {{words: Words} | null} state */
export function showRobot(line, state) {
  const { tone, headline, detail } = robotWords(state);
  line.dataset.tone = tone;
  if (line.textContent !== headline) line.textContent = headline;
  line.title = detail;
}
