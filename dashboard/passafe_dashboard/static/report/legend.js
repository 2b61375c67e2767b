// Legend of a chart: its signals, the value of each at the cursor, and which of them are drawn.

import { numberText, rangeText } from "./number_text.js";
import { lineDash, LINES } from "./theme.js";

const NAMESPACE = "http://www.w3.org/2000/svg";

/** @typedef {import("./payload.js").PlannedLine} Line */

/** @typedef {import("./payload.js").DrawnRun} Run */

/** @typedef {{line: Line, button: HTMLButtonElement, value: HTMLSpanElement, on: boolean}} Entry */

export class Legend {
  /** @param {import("./payload.js").ChartPlan} plan
   * @param {() => void} changed */
  constructor(plan, changed) {
    this.plan = plan;
    this.changed = changed;
    this.choice = plan.choices[0] ?? "";
    this.element = Object.assign(document.createElement("div"), { className: "legend" });
    if (plan.choices.length) this.element.append(this.select());
    /** @type {Entry[]} */
    this.entries = plan.kind === "rows" ? [] : plan.lines.map((line) => this.entry(line));
    this.summary = Object.assign(document.createElement("output"), { className: "value" });
    if (plan.kind === "rows") this.element.append(this.summary);
    const drawnFirst = [...this.entries].sort((a, b) => Number(b.on) - Number(a.on)); // a long legend scrolls
    this.element.append(...drawnFirst.map(({ button }) => button));
    this.update();
  }

  /** Returns the signals that are drawn. */
  get shown() {
    if (this.plan.kind === "rows") return this.plan.lines;
    return this.entries.filter((entry) => entry.on && this.offers(entry.line)).map((entry) => entry.line);
  }

  /** @param {Line} line */
  offers(line) {
    return line.choice === "" || line.choice === this.choice;
  }

  select() {
    const box = document.createElement("select");
    box.setAttribute("aria-label", `${this.plan.title}: what to draw`);
    box.append(...this.plan.choices.map((name) => new Option(name, name)));
    box.addEventListener("change", () => {
      this.choice = box.value;
      this.update();
      this.changed();
    });
    return box;
  }

  /** @param {Line} line
   * @returns {Entry} */
  entry(line) {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "key" });
    const value = Object.assign(document.createElement("span"), { className: "value" });
    if (this.plan.kind === "lines") button.append(this.swatch(line));
    button.append(Object.assign(document.createElement("span"), { textContent: line.label }), value);
    const entry = { line, button, value, on: !line.hidden };
    button.addEventListener("click", () => {
      entry.on = !entry.on;
      this.update();
      this.changed();
    });
    return entry;
  }

  /** @param {Line} line */
  swatch(line) {
    const picture = document.createElementNS(NAMESPACE, "svg");
    picture.setAttribute("width", "22");
    picture.setAttribute("height", "8");
    picture.setAttribute("aria-hidden", "true");
    const stroke = document.createElementNS(NAMESPACE, "line");
    const places = { x1: "0", x2: "22", y1: "4", y2: "4", "stroke-width": "2.5" };
    for (const [name, place] of Object.entries(places)) stroke.setAttribute(name, place);
    stroke.style.stroke = `var(--series-${line.style % LINES})`;
    stroke.setAttribute("stroke-dasharray", lineDash(this.plan, line).join(" "));
    picture.append(stroke);
    return picture;
  }

  update() {
    for (const { line, button, on } of this.entries) {
      button.hidden = !this.offers(line);
      button.setAttribute("aria-pressed", String(on));
    }
  }

  /** Writes the values at a time.
   * @param {Run[]} runs
   * @param {number} time
   * @param {import("./payload.js").Bands} bands */
  read(runs, time, bands) {
    if (this.plan.kind === "rows") {
      this.summary.textContent = runs.map((run) => this.activeRows(run, time)).join(" | ");
      return;
    }
    for (const { line, value } of this.entries) {
      if (!this.offers(line)) continue;
      const texts = runs.map((run) => this.text(run.tables[line.table], line, time, bands));
      value.textContent = texts.join(" | ");
    }
  }

  /** @param {Run} run
   * @param {number} time */
  activeRows(run, time) {
    const active = this.plan.lines.filter((line) => (run.tables[line.table].range(line.column, time)?.[1] ?? 0) > 0);
    return active.length ? `active: ${active.map((line) => line.label).join(", ")}` : "none active";
  }

  /** @param {import("./payload.js").Table} table
   * @param {Line} line
   * @param {number} time
   * @param {import("./payload.js").Bands} bands */
  text(table, line, time, bands) {
    const range = table.has(line.column) ? table.range(line.column, time) : null;
    const styles = bands[line.column];
    if (!styles) return rangeText(range);
    return range ? (styles[range[1]]?.name ?? numberText(range[1])) : "–";
  }
}
