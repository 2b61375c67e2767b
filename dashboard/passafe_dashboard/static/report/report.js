// Puts a report together: one run, or two over one another, with a cursor and a zoom that all plots share.

import { ChartPanel } from "./chart_panel.js";
import { JointScene } from "./joint_scene.js";
import { NearestBarriers } from "./nearest_barriers.js";
import { PlaneScene } from "./plane_scene.js";
import { SignalTable } from "./signal_table.js";
import { onThemeChange, readTheme } from "./theme.js";
import { TimeView } from "./time_view.js";
import { Toolbar } from "./toolbar.js";
import { PackedArrays } from "./unpack.js";

const JUMP_SPAN_S = 1;

/** Unpacks a run of the page's data.
 * @param {import("./payload.js").PackedRun} run
 * @returns {Promise<import("./payload.js").Run>} */
async function unpackRun(run) {
  const arrays = await PackedArrays.read(run.packed);
  const offset = run.offset_s ?? 0;
  const tables = Object.fromEntries(
    Object.entries(run.tables).map(([name, table]) => [name, new SignalTable(table, arrays, offset)]),
  );
  return { ...run, tables };
}

/** Builds the report into a page's places.
 * @param {import("./payload.js").ReportData} data reports/run_page.py
 * @param {Document} page */
export async function openReport(data, page) {
  const runs = await Promise.all(data.runs.map(unpackRun));
  const start = Math.min(...runs.map((run) => run.start_s + (run.offset_s ?? 0)));
  const end = Math.max(...runs.map((run) => run.end_s + (run.offset_s ?? 0)));
  const view = new TimeView(start, end);
  const panels = data.charts.map((plan) => new ChartPanel(plan, runs, view, data.bands, data.descriptions[plan.key] ?? plan.title));
  const place = (/** @type {string} */ id) => /** @type {HTMLElement} */ (page.getElementById(id));
  place("charts").append(...panels.map((panel) => panel.element));
  const canvas = /** @type {HTMLCanvasElement} */ (place("scene"));
  const scene = new (runs[0].scene.kind === "plane" ? PlaneScene : JointScene)(canvas, runs, view);
  const barriers = data.charts.find((plan) => plan.key === "h");
  const nearest = barriers ? new NearestBarriers(place("nearest"), barriers, runs[0]) : null;
  const toolbar = new Toolbar(place("toolbar"), view);
  let theme = readTheme();
  const drawAll = () => {
    for (const panel of panels) Object.assign(panel, { theme }).draw();
    scene.draw(theme);
  };
  const readAll = () => {
    for (const panel of panels) panel.readCursor();
    scene.draw(theme);
    nearest?.read(view.cursor);
    toolbar.read();
  };
  for (const panel of panels) panel.theme = theme;
  view.addEventListener("window", oncePerFrame(() => [drawAll(), readAll()]));
  view.addEventListener("cursor", oncePerFrame(readAll));
  new ResizeObserver(() => scene.draw(theme)).observe(/** @type {HTMLElement} */ (canvas.parentElement));
  onThemeChange(() => {
    theme = readTheme();
    drawAll();
  });
  page.addEventListener("click", (event) => jump(event, view, end - start));
  view.moveCursor(data.cursor_s ?? start);
  drawAll();
  readAll();
  page.body.dataset.ready = "true";
}

/** Follows a button that names a time.
 * @param {Event} event
 * @param {TimeView} view
 * @param {number} whole length of the run */
function jump(event, view, whole) {
  const target = /** @type {Element | null} */ (event.target);
  const button = /** @type {HTMLElement | null | undefined} */ (target?.closest?.("[data-jump]"));
  if (!button) return;
  view.jump(Number(button.dataset.jump), Math.min(Number(button.dataset.span ?? JUMP_SPAN_S), whole));
  for (const other of document.querySelectorAll("[data-jump][aria-current]")) other.removeAttribute("aria-current");
  button.setAttribute("aria-current", "true");
}

/** Returns a function that does a job once in the next frame, however often it is called before.
 * @param {() => unknown} job */
function oncePerFrame(job) {
  let waits = false;
  return () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      job();
    });
  };
}
