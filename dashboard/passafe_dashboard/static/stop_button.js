// The emergency stop of every page: a button and the Escape key press it, a second button clears the stop that is shown.
// The plant latches the stop; what is shown here is what its states say.

/** @typedef {{id: string | null, source: string | null}} Stop */

const SHOWN_MS = 12_000;
const NOTHING_TO_STOP = 409;

export class StopButton {
  /** @param {Document} page */
  constructor(page) {
    this.page = page;
    this.press = /** @type {HTMLButtonElement} */ (page.getElementById("stop"));
    this.clear = /** @type {HTMLButtonElement} */ (page.getElementById("clear"));
    this.answer = /** @type {HTMLOutputElement} */ (page.getElementById("stop-answer"));
    /** @type {string | null} */
    this.latched = null;
    /** What moves the robot after a clear, in a sentence. */
    this.afterwards = "The robot can be driven again after the clear.";
    this.answer.addEventListener("click", () => this.say(""));
    this.press.addEventListener("click", () => this.stop());
    this.clear.addEventListener("click", () => this.clearLatched());
    page.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || event.repeat) return;
      event.preventDefault();
      this.stop();
    });
  }

  stop() {
    return this.request("/api/stop", "Stopping …");
  }

  async clearLatched() {
    if (!this.latched) return;
    if (!window.confirm(`Is the way free? ${this.afterwards}`)) {
      this.say("Not cleared: the robot stays stopped.", true);
      return;
    }
    await this.request(`/api/clear/${this.latched}`, "Clearing …");
  }

  /** Shows the stop that is latched at the plant.
   * @param {Stop} stop */
  show(stop) {
    if (stop.id === this.latched) return;
    this.say(stop.id ? `Stopped: pressed at ${stop.source}.` : "");
    this.latched = stop.id;
    this.clear.hidden = !stop.id;
    this.clear.title = stop.id ? `Stopped: pressed at ${stop.source}` : "";
    this.page.body.toggleAttribute("data-stopped", Boolean(stop.id));
  }

  /** @param {string} path
   * @param {string} doing */
  async request(path, doing) {
    this.say(doing);
    try {
      const response = await fetch(path, { method: "PUT" });
      const body = await response.json();
      if (response.ok) this.show(body);
      else this.say(response.status === NOTHING_TO_STOP ? body.detail : `Failed: ${body.detail}`, true);
    } catch (error) {
      this.say(`Failed: the dashboard does not answer (${reason(error)}). Use passafe stop, or the robot's own switch.`, true);
    }
  }

  /** Says how a request went: aloud to those who listen, and in sight where it failed; buttons and colour show the rest.
   * @param {string} text
   * @param {boolean} failed */
  say(text, failed = false) {
    this.answer.textContent = text;
    clearTimeout(this.hiding);
    if (failed) this.hiding = setTimeout(() => this.answer.removeAttribute("data-failed"), SHOWN_MS);
    this.answer.toggleAttribute("data-failed", failed);
  }
}

/** @param {unknown} error */
function reason(error) {
  return error instanceof Error ? error.message : String(error);
}
