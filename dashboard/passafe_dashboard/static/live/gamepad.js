// A gamepad: sticks steer while the shoulder button is held; buttons stop, clutch and take the controls.

import { withoutDeadZone } from "./stick.js";

/** @typedef {import("./types.js").Pair} Pair */

export const BUTTONS = { stop: 1, clutch: 4, dead_man: 5, take: 9 };
const DEAD_ZONE = 0.12;

/** @typedef {{connected: boolean, engaged: boolean, clutched: boolean, values: Pair[], stop: boolean, take: boolean}} Reading */

/** @type {Reading} */
const NOTHING = { connected: false, engaged: false, clutched: false, values: [], stop: false, take: false };

export class GamepadReader {
  constructor() {
    /** @type {boolean[]} */
    this.before = [];
  }

  /** Returns what a gamepad says now; presses of stop and take are reported once.
   * @param {ReadonlyArray<{axes: readonly number[], buttons: readonly {pressed: boolean}[]} | null>} gamepads
   * @param {number} pads number of planes to steer
   * @returns {Reading} */
  read(gamepads, pads) {
    const gamepad = [...gamepads].find((each) => each !== null);
    if (!gamepad) return NOTHING;
    const pressed = gamepad.buttons.map((button) => button.pressed);
    const begins = (/** @type {number} */ index) => Boolean(pressed[index] && !this.before[index]);
    const [stop, take] = [begins(BUTTONS.stop), begins(BUTTONS.take)];
    this.before = pressed;
    const values = Array.from({ length: pads }, (_, pad) => {
      const [x, y] = [gamepad.axes[2 * pad] ?? 0, gamepad.axes[2 * pad + 1] ?? 0];
      return withoutDeadZone([x, -y], DEAD_ZONE);
    });
    return {
      connected: true,
      engaged: Boolean(pressed[BUTTONS.dead_man]),
      clutched: Boolean(pressed[BUTTONS.clutch]),
      values,
      stop,
      take,
    };
  }
}
