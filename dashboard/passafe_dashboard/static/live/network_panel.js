// The network: delay, jitter and loss of each link by sliders, an outage, and presets of real networks.
// What is shown is what the process at the end of the link has acknowledged; a request that waits is marked.

import { byId, element, setText } from "./elements.js";
import { request } from "./requests.js";

/** @typedef {{name: string, unit: string, most: number, scale: number}} Quantity */

/** @type {Record<string, Quantity>} */
export const QUANTITIES = {
  delay_s: { name: "delay", unit: "ms", most: 1000, scale: 1000 },
  jitter_s: { name: "jitter", unit: "ms", most: 200, scale: 1000 },
  loss: { name: "loss", unit: "%", most: 100, scale: 100 },
};

export const LINK_WORDS = {
  "operator-to-filter": "you → filter",
  "filter-to-plant": "filter → robot",
  "plant-to-filter": "robot → filter",
  "plant-to-operator": "robot → you",
};

const OUTAGE_S = 3600;
const NO_NETWORK = { network: "", delay_s: 0, jitter_s: 0, loss: 0, distribution: "uniform", quantiles_s: [], correlation: 0, burst_enter: 0, burst_loss_good: 0, duplicate: 0, corrupt: 0, rate_hz: 0, outages_s: [] };

/** Returns the position of a slider for a value: finer where values are small.
 * @param {number} value in the quantity's unit
 * @param {number} most */
export function sliderOf(value, most) {
  return 100 * Math.sqrt(Math.min(Math.max(value / most, 0), 1));
}

/** Returns the value of a slider, rounded as people set it.
 * @param {number} position 0 to 100
 * @param {number} most */
export function valueOf(position, most) {
  const value = most * (position / 100) ** 2;
  const step = value < 20 ? 1 : value < 100 ? 5 : 10;
  return Math.round(value / step) * step;
}

/** Returns a setting in words; "+" before one that comes on top of a model of a real network.
 * @param {number} value
 * @param {Quantity} quantity
 * @param {string} network */
export function settingText(value, quantity, network = "") {
  if (network && !value) return "modelled";
  const shown = value * quantity.scale;
  return `${network ? "+ " : ""}${Number(shown.toFixed(shown < 10 ? 1 : 0))} ${quantity.unit}`;
}

export class NetworkPanel {
  /** @param {import("./types.js").Setup} setup */
  constructor(setup) {
    this.panel = byId("panel-network");
    this.answer = byId("panel-answer");
    /** @type {Map<string, LinkRow>} */
    this.rows = new Map();
    const grid = element("div", "network");
    grid.append(element("span", "head", "link"), ...Object.values(QUANTITIES).map(({ name }) => element("span", "head", name)), element("span", "head", ""));
    for (const name of setup.links) this.rows.set(name, new LinkRow(grid, name, (change) => this.change([name], change)));
    this.panel.replaceChildren(grid, this.presets(setup));
  }

  /** @param {import("./types.js").Setup} setup */
  presets(setup) {
    const place = element("p", "preset");
    const label = element("label", "", "All links like ");
    this.preset = document.createElement("select");
    this.preset.append(new Option("choose a network …", ""), ...setup.networks.map(({ name, title }) => new Option(title, name)));
    label.append(this.preset);
    this.preset.addEventListener("change", () => this.choose());
    const clear = /** @type {HTMLButtonElement} */ (element("button", "", "Perfect network"));
    clear.type = "button";
    clear.addEventListener("click", () => this.change([...this.rows.keys()], NO_NETWORK));
    place.append(label, clear);
    return place;
  }

  choose() {
    const name = this.preset?.value;
    if (name) this.change([...this.rows.keys()], { ...NO_NETWORK, network: name });
  }

  /** @param {string[]} links
   * @param {Record<string, unknown>} settings */
  async change(links, settings) {
    setText(this.answer, "requesting …");
    const answers = await Promise.all(links.map((name) => request("PUT", `/api/links/${encodeURIComponent(name)}`, settings)));
    const refused = answers.flatMap((answer, i) => (answer.ok ? [] : [`${links[i]}: ${answer.reason}`]));
    const done = links.length > 1 ? "acknowledged by all links" : `acknowledged: ${LINK_WORDS[/** @type {keyof typeof LINK_WORDS} */ (links[0])] ?? links[0]}`;
    setText(this.answer, refused.length ? refused.join("; ") : done);
    for (const name of links) this.rows.get(name)?.settle();
  }

  /** @param {any[]} states */
  show(states) {
    for (const { link, settings } of states) this.rows.get(link)?.show(settings);
    const networks = new Set(states.map(({ settings }) => settings?.network ?? ""));
    if (this.preset && document.activeElement !== this.preset) this.preset.value = networks.size === 1 ? [...networks][0] : "";
  }
}

class LinkRow {
  /** @param {HTMLElement} grid
   * @param {string} name
   * @param {(change: Record<string, unknown>) => void} change */
  constructor(grid, name, change) {
    const words = LINK_WORDS[/** @type {keyof typeof LINK_WORDS} */ (name)] ?? name;
    this.pending = false;
    this.name = element("span", "link-name", words);
    grid.append(this.name);
    this.sliders = Object.entries(QUANTITIES).map(([field, quantity]) => {
      const label = document.createElement("label");
      const input = document.createElement("input");
      Object.assign(input, { type: "range", min: "0", max: "100", step: "0.5", value: "0" });
      input.setAttribute("aria-label", `${quantity.name} ${words}`);
      label.dataset.name = quantity.name; // its heading where there is no room for one above the column
      const output = document.createElement("output");
      label.append(input, output);
      grid.append(label);
      input.addEventListener("input", () => {
        this.pending = true;
        output.className = "pending";
        setText(output, `${valueOf(Number(input.value), quantity.most)} ${quantity.unit}`);
      });
      input.addEventListener("change", () => change({ [field]: valueOf(Number(input.value), quantity.most) / quantity.scale }));
      return { field, quantity, input, output };
    });
    this.outage = /** @type {HTMLButtonElement} */ (element("button", "", "Outage"));
    this.outage.type = "button";
    this.outage.setAttribute("aria-pressed", "false");
    this.outage.setAttribute("aria-label", `Outage ${words}`);
    this.outage.addEventListener("click", () => {
      const on = this.outage.getAttribute("aria-pressed") === "true";
      change({ outages_s: on ? [] : [[0, OUTAGE_S]] });
    });
    grid.append(this.outage);
  }

  settle() {
    this.pending = false;
  }

  /** Shows the settings in force, unless the reader has a slider in hand.
   * @param {any} settings */
  show(settings) {
    if (this.pending) return;
    this.name.title = settings?.network ?? "";
    for (const { field, quantity, input, output } of this.sliders) {
      output.className = "";
      setText(output, settings ? settingText(settings[field], quantity, settings.network) : "–");
      input.value = String(settings ? sliderOf(settings[field] * quantity.scale, quantity.most) : 0);
      input.disabled = !settings;
      input.setAttribute("aria-valuetext", output.textContent ?? "");
    }
    this.outage.disabled = !settings;
    this.outage.setAttribute("aria-pressed", String(Boolean(settings?.outages.length)));
    setText(this.outage, settings?.outages.length ? "End it" : "Outage");
  }
}
