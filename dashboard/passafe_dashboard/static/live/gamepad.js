// A gamepad: sticks steer while the shoulder button is held; buttons stop, clutch and take the controls.

import { withoutDeadZone } from "./stick.js";

/** @typedef {import("./types.js").Pair} Pair */

export const BUTTONS = { stop: 1, clutch: 4, dead_man: 5, take: 9 };
const DEAD_ZONE = 0.12;

/** What is read of a gamepad.
 * @typedef {{axes: readonly number[], buttons: readonly {pressed: boolean}[]}} Gamepad */

/** @typedef {{connected: boolean, engaged: boolean, clutched: boolean, values: Pair[], stop: boolean, take: boolean}} Reading */

/** @type {Reading} */
const NOTHING = { connected: false, engaged: false, clutched: false, values: [], stop: false, take: false };

export class GamepadReader {
  constructor() {
    /** @type {Map<number, boolean[]>} buttons of each gamepad at the last look */
    this.before = new Map();
  }

  /** Returns what gamepads say now: the first whose dead-man is held steers, and the buttons of all count.
   * Presses of stop and take are reported once.
   * @param {ReadonlyArray<Gamepad | null>} gamepads
   * @param {number} pads number of planes to steer
   * @returns {Reading} */
  read(gamepads, pads) {
    const found = [...gamepads].flatMap((gamepad, slot) => (gamepad ? [{ ...this.look(gamepad, slot), axes: gamepad.axes }] : []));
    for (const slot of this.before.keys()) if (!gamepads[slot]) this.before.delete(slot);
    const steering = found.find(({ pressed }) => pressed[BUTTONS.dead_man]) ?? found[0];
    if (!steering) return NOTHING;
    const { axes, pressed } = steering;
    const values = Array.from({ length: pads }, (_, pad) => {
      const [x, y] = [axes[2 * pad] ?? 0, axes[2 * pad + 1] ?? 0];
      return withoutDeadZone([x, -y], DEAD_ZONE);
    });
    return {
      connected: true,
      engaged: Boolean(pressed[BUTTONS.dead_man]),
      clutched: Boolean(pressed[BUTTONS.clutch]),
      values,
      stop: found.some(({ begun }) => begun[BUTTONS.stop]),
      take: found.some(({ begun }) => begun[BUTTONS.take]),
    };
  }

  /** Returns which buttons of a gamepad are held, and which were not at the last look.
   * @param {Gamepad} gamepad
   * @param {number} slot */
  look(gamepad, slot) {
    const before = this.before.get(slot) ?? [];
    const pressed = gamepad.buttons.map((button) => button.pressed);
    this.before.set(slot, pressed);
    return { pressed, begun: pressed.map((held, i) => held && !before[i]) };
  }
}
