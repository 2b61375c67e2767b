// The engineers' sheet: every number of filter, plant, processes, topics and links, and charts over time.

import { byId, element, setText } from "./elements.js";
import { fill, number, percent, seconds, vector } from "./number_table.js";
import { LiveCharts } from "./live_charts.js";
import { linkRow } from "./link_rows.js";
import { ageText } from "./delays_panel.js";

/** @typedef {import("./types.js").Now} Now */

const NUMBERS_EVERY_MS = 200;
const CHARTS_EVERY_MS = 66;
const MOST_EVENTS = 50;

export class EngineerSheet {
  /** @param {import("./types.js").Setup} setup
   * @param {{ticks: import("./live_table.js").LiveTable, states: import("./live_table.js").LiveTable}} tables */
  constructor(setup, tables) {
    this.setup = setup;
    this.tolerances = setup.tolerances;
    this.charts = new LiveCharts(setup, tables, byId("charts"));
    this.newestEvent = -1;
    this.numbersAt = -Infinity;
    this.chartsAt = -Infinity;
    for (const chip of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("#status-counts [data-status]"))) this.colour(chip, chip.dataset.status ?? "");
  }

  /** @param {HTMLElement} chip
   * @param {string} status */
  colour(chip, status) {
    const style = this.setup.statuses[status];
    if (style) Object.assign(chip.style, { background: style.background, color: style.text });
  }

  /** @param {Now} now
   * @param {any} theme
   * @param {number} at
   * @param {number} lost */
  draw(now, theme, at, lost) {
    if (at - this.chartsAt >= CHARTS_EVERY_MS) {
      this.chartsAt = at;
      this.charts.draw(theme);
    }
    if (lost) setText(byId("lost"), `This browser was too slow: the charts omit ${lost} rows. The lowest values in the tables include them.`);
    if (at - this.numbersAt < NUMBERS_EVERY_MS && now.liveness.state !== "ended") return;
    this.numbersAt = at;
    if (now.filter) this.showFilter(now.filter);
    this.markViolated(now);
    if (now.plant) this.showPlant(now.plant);
    setText(byId("verdict"), now.verdict?.words ?? "–");
    byId("verdict").dataset.outcome = now.verdict?.outcome ?? "";
    this.showBarriers(now);
    this.showEnergy(now);
    this.showTraffic(now);
    this.showEvents(now.events);
  }

  /** @param {any} filter */
  showFilter(filter) {
    const chip = byId("status");
    this.colour(chip, filter.status);
    setText(chip, filter.status);
    setText(byId("status-meaning"), filter.meaning);
    setText(byId("state-age"), ageText(filter.state_age_ms));
    setText(byId("command-age"), ageText(filter.command_age_ms));
    setText(byId("command-words"), filter.command_words);
    setText(byId("u-h"), vector(filter.u_h));
    setText(byId("u-nominal"), vector(filter.u_nominal));
    setText(byId("u"), vector(filter.u));
    this.showOverride(filter);
    setText(byId("certificate"), certificateText(filter.certificate));
    const rows = filter.rows.map((/** @type {any} */ row) => [row.name, row.active ? "active" : "no", number(row.margin), number(row.dual), percent(row.share)]);
    fill(byId("rows"), rows, (row, r) => row.classList.toggle("bad", filter.rows[r].margin < -this.tolerances.certificate));
  }

  /** A barrier that does not hold wins over whatever the solver says of itself.
   * @param {Now} now */
  markViolated(now) {
    const violated = now.gaps.filter(({ h }) => h < -this.tolerances.h).map(({ name }) => name);
    if (!violated.length) return;
    const chip = byId("status");
    Object.assign(chip.style, { background: "var(--bad)", color: "var(--paper)" });
    setText(chip, `${now.filter?.status ?? "no tick"}, violated: ${violated.join(", ")}`);
  }

  /** Shows what was held back; the percentage is rounded down, so that the filter passes at least what is shown.
   * @param {any} filter */
  showOverride({ override, u_h }) {
    const asks = Math.hypot(...u_h) > 1e-3;
    const held = override ? `${number(override.held_back_norm)}  ${vector(override.held_back)}` : "–";
    setText(byId("held-back"), asks || !override ? held : "nothing of the operator's: the robot's own feedback is held back");
    const passes = override?.unavoidable ? "no part of it" : `${Math.floor(100 * (override?.allowed_fraction ?? 0))} %`;
    setText(byId("allowed"), override && asks ? passes : "–");
    const distance = byId("infeasibility");
    setText(distance, number(override?.distance_to_infeasibility));
    distance.classList.toggle("negative", override?.distance_to_infeasibility < 0);
  }

  /** @param {any} plant */
  showPlant(plant) {
    setText(byId("plant-phase"), `${plant.phase}: ${plant.meaning}`);
    setText(byId("position"), vector(plant.x.slice(0, 2)));
  }

  /** @param {Now} now */
  showBarriers(now) {
    const rows = now.worst.barriers.map((/** @type {any} */ barrier, /** @type {number} */ index) => [
      barrier.name,
      number(now.plant?.h[index]?.value),
      number(barrier.measured?.value),
      seconds(barrier.measured?.at_s),
      now.filter?.barriers[index]?.psi.map((/** @type {number} */ value) => number(value)).join(", ") ?? "–",
    ]);
    fill(byId("barriers"), rows, (row, r) => {
      row.cells[1].classList.toggle("negative", now.plant?.h[r]?.value < -this.tolerances.h);
      row.cells[2].classList.toggle("negative", now.worst.barriers[r].measured?.value < -this.tolerances.h);
    });
  }

  /** Colours follow what is required of the run: a margin that no property asks for is not a fault.
   * @param {Now} now */
  showEnergy(now) {
    const { filter, worst, energy } = now;
    const { power_margin_w, tank_j } = this.tolerances;
    const tanked = energy?.kind === "tank";
    signed("power-margin", filter?.power_margin_w, "W", tanked ? Infinity : power_margin_w);
    signed("power-margin-worst", worst.power_margin_w?.value, "W", tanked ? Infinity : power_margin_w);
    setText(byId("power-margin-worst-at"), seconds(worst.power_margin_w?.at_s));
    setText(byId("power-tolerance"), tanked ? "none: the tank is required" : `${number(power_margin_w)} W`);
    signed("tank", filter?.tank_j, "J", tank_j);
    signed("tank-worst", worst.tank_j?.value, "J", tank_j);
    setText(byId("tank-worst-at"), seconds(worst.tank_j?.at_s));
    setText(byId("tank-tolerance"), `${number(tank_j)} J`);
    setText(byId("slack"), filter ? `${number(filter.slack_w)} W` : "–");
  }

  /** @param {Now} now */
  showTraffic(now) {
    const processes = now.processes.map((p) =>
      p.state === "no report"
        ? [p.process, p.state, "–", "–", "–", "–", "–"]
        : [p.process, p.state, p.rate_hz.toFixed(1), `${p.overruns}`, `${p.steps_skipped}`, p.late_us_max.toFixed(0), p.age_s.toFixed(1)],
    );
    fill(byId("processes"), processes, (row, r) => row.classList.toggle("bad", now.processes[r].state === "silent"));
    const topics = now.topics.map((t) => [t.topic, t.source, t.rate_hz.toFixed(1), `${t.received}`, `${t.gaps}`, t.age_s.toFixed(2), t.late ? "late" : "ok"]);
    fill(byId("topics"), topics, (row, r) => row.classList.toggle("bad", now.topics[r].late));
    fill(byId("link-states"), now.link_states.map(linkRow));
    const missing = now.topics.filter((t) => t.topic === "tick" || t.topic === "state").reduce((n, t) => n + t.gaps, 0);
    setText(byId("missing"), missing ? `${missing} ticks and states did not reach this page; a log may have them.` : "");
    for (const cell of /** @type {NodeListOf<HTMLElement>} */ (byId("status-counts").querySelectorAll("td[data-count]"))) {
      setText(cell, `${now.status_counts[cell.dataset.count ?? ""]}`);
    }
    const effects = now.links.map((l) => `${l.link}: ${l.count} ${l.effect}`);
    const unfit = now.mismatched_messages ? [`${now.mismatched_messages} messages do not fit the scenario`] : [];
    setText(byId("links"), [...effects, ...unfit].join(" · "));
  }

  forgetEvents() {
    this.newestEvent = -1;
    byId("events").replaceChildren();
  }

  /** @param {any[]} events */
  showEvents(events) {
    const list = byId("events");
    for (const event of events) {
      if (event.number <= this.newestEvent) continue;
      this.newestEvent = event.number;
      const item = element("div", event.severity);
      item.append(element("span", "severity", event.severity), ` ${event.source}: ${event.text}`);
      list.prepend(item);
      while (list.children.length > MOST_EVENTS) list.lastChild?.remove();
    }
  }
}

/** Returns the certificate in words; a decision that no solver made needs none.
 * @param {{solver: string, accepted: boolean, primal_residual: number, dual_residual: number, gap: number}} certificate */
export function certificateText({ solver, accepted, primal_residual, dual_residual, gap }) {
  if (!solver || solver === "none") return "no program was needed";
  const numbers = `primal ${number(primal_residual)}, dual ${number(dual_residual)}, gap ${number(gap)}`;
  return `${solver} ${accepted ? "accepted" : "refused"}: ${numbers}`;
}

/** @param {string} id
 * @param {number | null | undefined} value
 * @param {string} unit
 * @param {number} tolerance */
function signed(id, value, unit, tolerance) {
  const cell = byId(id);
  setText(cell, value === null || value === undefined ? "–" : `${number(value)} ${unit}`);
  cell.classList.toggle("negative", (value ?? 0) < -tolerance);
}
