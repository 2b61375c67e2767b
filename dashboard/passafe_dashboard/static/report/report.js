// Puts a report together: one run, or two over one another, with a cursor and a zoom that all plots share.

import { ChartPanel } from "./chart_panel.js";
import { NearestBarriers } from "./nearest_barriers.js";
import { JointScene, PlaneScene } from "./scene.js";
import { SignalTable } from "./signal_table.js";
import { onThemeChange, readTheme } from "./theme.js";
import { TimeView } from "./time_view.js";
import { Toolbar } from "./toolbar.js";
import { PackedArrays } from "./unpack.js";

const JUMP_SPAN_S = 1;

/** Unpacks a run of the page's data.
 * @param {any} run run_record/run_payload.py */
async function unpackRun(run) {
  const arrays = await PackedArrays.read(run.packed);
  const offset = run.offset_s ?? 0;
  const tables = Object.fromEntries(
    Object.entries(run.tables).map(([name, table]) => [name, new SignalTable(table, arrays, offset)]),
  );
  return { ...run, tables };
}

/** Builds the report into a page's places.
 * @param {any} data reports/run_page.py
 * @param {Document} page */
export async function openReport(data, page) {
  const runs = await Promise.all(data.runs.map(unpackRun));
  const start = Math.min(...runs.map((run) => run.start_s + (run.offset_s ?? 0)));
  const end = Math.max(...runs.map((run) => run.end_s + (run.offset_s ?? 0)));
  const view = new TimeView(start, end);
  const panels = data.charts.map((plan) => new ChartPanel(plan, runs, view, data.bands, data.descriptions[plan.key] ?? plan.title));
  page.querySelector("#charts").append(...panels.map((panel) => panel.element));
  const scene = new (runs[0].scene.kind === "plane" ? PlaneScene : JointScene)(page.querySelector("#scene"), runs, view);
  const barriers = data.charts.find((plan) => plan.key === "h");
  const nearest = barriers ? new NearestBarriers(page.querySelector("#nearest"), barriers, runs[0]) : null;
  const toolbar = new Toolbar(page.querySelector("#toolbar"), view);
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
  new ResizeObserver(() => scene.draw(theme)).observe(scene.canvas.parentElement);
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

/** Follows a button that names a time. */
function jump(event, view, whole) {
  const button = event.target.closest?.("[data-jump]");
  if (!button) return;
  view.jump(Number(button.dataset.jump), Math.min(Number(button.dataset.span ?? JUMP_SPAN_S), whole));
  for (const other of document.querySelectorAll("[data-jump][aria-current]")) other.removeAttribute("aria-current");
  button.setAttribute("aria-current", "true");
}

/** Returns a function that does a job once in the next frame, however often it is called before. */
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
