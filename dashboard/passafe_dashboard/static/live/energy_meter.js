// The energy tank as a bar with its reserve; where there is no tank, the power margin in words.

import { numberText } from "../report/number_text.js";
import { byId, element, setText } from "./elements.js";

export class EnergyMeter {
  constructor() {
    const place = byId("energy");
    this.tank = element("div", "tank");
    this.level = element("div", "level");
    this.reserve = element("div", "reserve");
    this.value = element("span", "value");
    this.note = element("span", "note");
    this.tank.append(this.level, this.reserve);
    place.replaceChildren(this.tank, this.value, this.note);
  }

  /** @param {any} energy
   * @param {number} tolerance of the power margin, W */
  show(energy, tolerance) {
    if (!energy) return;
    this.tank.hidden = energy.kind !== "tank";
    if (energy.kind === "tank") this.showTank(energy);
    else this.showPower(energy, tolerance);
  }

  /** @param {{level_j: number, reserve_j: number, max_j: number, asked: boolean}} tank */
  showTank({ level_j, reserve_j, max_j, asked }) {
    const low = level_j < reserve_j;
    this.level.style.width = `${(100 * Math.min(Math.max(level_j / max_j, 0), 1)).toFixed(1)}%`;
    this.level.dataset.low = String(low);
    this.reserve.style.left = `${(100 * Math.min(reserve_j / max_j, 1)).toFixed(1)}%`;
    setText(this.value, `${numberText(Math.abs(level_j) < 5e-4 ? 0 : level_j, 3)} J`);
    const held = low ? "below its reserve: only safety may draw on it" : `reserve ${numberText(reserve_j, 2)} J, full at ${numberText(max_j, 2)} J`;
    setText(this.note, asked ? `Tank ${held}` : `Not asked for in this mode. Tank ${held}`);
  }

  /** @param {{margin_w: number, asked: boolean}} power
   * @param {number} tolerance */
  showPower({ margin_w, asked }, tolerance) {
    const small = Math.abs(margin_w) <= tolerance;
    setText(this.value, `${small ? "0" : numberText(margin_w, 2)} W`);
    const words = margin_w >= -tolerance ? "Room before the robot would give out energy" : "The robot gives out more than it was given";
    setText(this.note, asked ? words : `Not asked for in this mode. ${words}`);
  }
}
