// A tone and a vibration while a command is held back; off until the reader switches them on.

const LOW_HZ = 140;
const HIGH_HZ = 320;
const MOST_GAIN = 0.06;

/** Returns how much of a command is held back, 0 to 1.
 * @param {any} filter of the page's state */
export function heldShare(filter) {
  const override = filter?.override;
  if (!override) return 0;
  const asked = Math.hypot(...filter.u_h);
  if (asked < 1e-3) return 0;
  return Math.min(override.held_back_norm / asked, 1);
}

export class Feel {
  /** @param {HTMLInputElement} box switches it on */
  constructor(box) {
    this.box = box;
    /** @type {AudioContext | null} */
    this.audio = null;
    box.addEventListener("change", () => this.start());
  }

  start() {
    if (!this.box.checked || this.audio) return;
    this.audio = new AudioContext();
    this.tone = this.audio.createOscillator();
    this.gain = this.audio.createGain();
    this.gain.gain.value = 0;
    this.tone.connect(this.gain).connect(this.audio.destination);
    this.tone.start();
  }

  /** @param {number} held 0 to 1
   * @param {boolean} driving whether this page drives */
  show(held, driving) {
    const on = this.box.checked && driving && held > 0.02;
    if (this.audio && this.tone && this.gain) {
      this.gain.gain.setTargetAtTime(on ? MOST_GAIN * held : 0, this.audio.currentTime, 0.03);
      this.tone.frequency.setTargetAtTime(LOW_HZ + (HIGH_HZ - LOW_HZ) * held, this.audio.currentTime, 0.03);
    }
    if (!on) return;
    navigator.vibrate?.(Math.round(20 * held));
    for (const gamepad of navigator.getGamepads?.() ?? []) {
      gamepad?.vibrationActuator?.playEffect("dual-rumble", { duration: 60, weakMagnitude: held, strongMagnitude: 0.4 * held });
    }
  }
}
