// Charts over time of the engineers' sheet: those of the report, over the newest rows.

import { ChartPanel } from "../report/chart_panel.js";
import { readTheme } from "../report/theme.js";
import { TimeView } from "../report/time_view.js";

export class LiveCharts {
  /** @param {import("./types.js").Setup} setup
   * @param {{ticks: import("./live_table.js").LiveTable, states: import("./live_table.js").LiveTable}} tables
   * @param {HTMLElement} place */
  constructor(setup, tables, place) {
    this.tables = tables;
    this.window_s = setup.window_s;
    this.view = new TimeView(0, setup.window_s);
    this.panels = (setup.charts ?? []).map(
      (plan) => new ChartPanel(plan, [{ tables, label: "now" }], this.view, setup.bands, `${plan.title} over time`),
    );
    const theme = readTheme();
    for (const panel of this.panels) Object.assign(panel, { theme });
    place.replaceChildren(...this.panels.map(({ element }) => /** @type {HTMLElement} */ (element)));
  }

  /** @param {any} theme */
  draw(theme) {
    const newest = Math.max(this.tables.ticks.newest || 0, this.tables.states.newest || 0);
    if (!newest) return;
    const { view } = this;
    const followed = view.to >= view.end - 1e-9;
    const span = Math.min(view.to - view.from, this.window_s);
    view.start = Math.max(newest - this.window_s, 0);
    view.end = Math.max(newest, view.start + 0.1);
    if (followed) {
      view.to = view.end;
      view.from = Math.max(view.end - Math.max(span, 0.5), view.start);
      if (span > 0.9 * this.window_s) view.from = view.start;
      view.cursor = view.end;
    }
    for (const panel of this.panels) {
      Object.assign(panel, { theme });
      panel.draw();
    }
  }
}
