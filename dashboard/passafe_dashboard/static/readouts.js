// Numbers and words of the page. Text is set as text, never as markup.
// A value is marked as negative when it is below zero by more than a review tolerates.
const { tolerances } = JSON.parse(document.getElementById("setup").textContent);

const byId = (id) => document.getElementById(id);

export function setText(element, text) {
  if (element && element.textContent !== text) element.textContent = text;
}

function set(id, text) {
  setText(byId(id), text);
}

export function number(value, digits = 4) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  const text = size !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential(2) : value.toFixed(digits);
  return text.replaceAll("-", "−");
}

const vector = (values) => (values && values.length ? `(${values.map((v) => number(v, 3)).join(", ")})` : "–");
const seconds = (value) => (value === null || value === undefined ? "–" : `${value.toFixed(2)} s`);
const percent = (share) => `${number(100 * share, 0)} %`;
const milliseconds = (value) => (value === null ? "nothing received yet" : `${value.toFixed(1)} ms`);

function setSigned(element, value, unit, tolerance) {
  setText(element, value === null || value === undefined ? "–" : `${number(value)} ${unit}`);
  element.classList.toggle("negative", value < -tolerance);
}

// Makes a table body have these rows of text; cells are reused, so nothing flickers and selection stays.
export function fill(bodyId, rows, decorate) {
  const body = byId(bodyId);
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach((cells, r) => {
    const row = body.rows[r] ?? body.insertRow();
    cells.forEach((text, c) => {
      let cell = row.cells[c];
      if (!cell) {
        cell = document.createElement(c === 0 ? "th" : "td");
        if (c === 0) cell.scope = "row";
        row.append(cell);
      }
      setText(cell, text);
    });
    decorate?.(row, r);
  });
}

export function showConnection(state, text) {
  const connection = byId("connection");
  connection.dataset.state = state;
  setText(connection, { live: "live", waiting: "waiting", silent: "no messages", lost: "lost", ended: "run ended" }[state]);
  const banner = byId("banner");
  banner.hidden = state === "live";
  banner.dataset.state = state;
  setText(banner, state === "live" ? "" : text);
}

export function showLost(count) {
  set("lost", `This browser was too slow: the charts omit ${count} rows. The lowest values in the tables include them.`);
}

export function showState(now) {
  if (!byId("main")) return;
  if (now.filter) showFilter(now.filter);
  if (now.plant) showPlant(now.plant);
  showVerdict(now.verdict);
  showBarriers(now);
  showEnergy(now);
  showTraffic(now);
  showEvents(now.events);
}

function showFilter(filter) {
  const chip = byId("status");
  chip.dataset.status = filter.status;
  setText(chip, filter.status);
  set("status-meaning", filter.meaning);
  set("mode", filter.mode);
  set("law", filter.law);
  set("state-age", milliseconds(filter.state_age_ms));
  set("command-age", milliseconds(filter.command_age_ms));
  set("command-words", filter.command_words);
  set("u-h", vector(filter.u_h));
  set("u-nominal", vector(filter.u_nominal));
  set("u", vector(filter.u));
  showOverride(filter.override);
  const { solver, accepted, primal_residual: primal, dual_residual: dual, gap } = filter.certificate;
  const verdict = accepted ? "accepted" : "refused";
  set("certificate", solver ? `${solver} ${verdict}: primal ${number(primal)}, dual ${number(dual)}, gap ${number(gap)}` : "–");
  const rows = filter.rows.map((row) => [row.name, row.active ? "active" : "no", number(row.margin), number(row.dual), percent(row.share)]);
  fill("rows", rows, (row, r) => row.classList.toggle("bad", filter.rows[r].margin < -tolerances.certificate));
}

// A tick may not report it. The percentage is rounded down: the filter passes at least what the page shows.
function showOverride(override) {
  set("held-back", override ? `${number(override.held_back_norm)}  ${vector(override.held_back)}` : "–");
  const allowed = override?.unavoidable ? "no part of it" : `${Math.floor(100 * (override?.allowed_fraction ?? 0))} %`;
  set("allowed", override ? allowed : "–");
  const distance = byId("infeasibility");
  setText(distance, number(override?.distance_to_infeasibility));
  distance.classList.toggle("negative", override?.distance_to_infeasibility < 0);
}

function showVerdict(verdict) {
  set("verdict", verdict?.words ?? "–");
  byId("verdict").dataset.outcome = verdict?.outcome ?? "";
}

function showPlant(plant) {
  set("plant-time", `${plant.time_s.toFixed(2)} s`);
  set("plant-phase", `${plant.phase}: ${plant.meaning}`);
  set("position", vector(plant.x.slice(0, 2)));
}

function showBarriers(now) {
  const rows = now.worst.barriers.map((barrier, index) => [
    barrier.name,
    number(now.plant?.h[index]?.value),
    number(barrier.measured?.value),
    seconds(barrier.measured?.at_s),
    now.filter?.barriers[index]?.psi.map((value) => number(value, 3)).join(", ") ?? "–",
  ]);
  fill("barriers", rows, (row, r) => {
    row.cells[1].classList.toggle("negative", now.plant?.h[r]?.value < -tolerances.h);
    row.cells[2].classList.toggle("negative", now.worst.barriers[r].measured?.value < -tolerances.h);
  });
}

function showEnergy(now) {
  setSigned(byId("power-margin"), now.filter?.power_margin_w, "W", tolerances.power_margin_w);
  setSigned(byId("power-margin-worst"), now.worst.power_margin_w?.value, "W", tolerances.power_margin_w);
  set("power-margin-worst-at", seconds(now.worst.power_margin_w?.at_s));
  setSigned(byId("tank"), now.filter?.tank_j, "J", tolerances.tank_j);
  setSigned(byId("tank-worst"), now.worst.tank_j?.value, "J", tolerances.tank_j);
  set("tank-worst-at", seconds(now.worst.tank_j?.at_s));
  set("slack", now.filter ? `${number(now.filter.slack_w)} W` : "–");
}

function showTraffic(now) {
  const processes = now.processes.map((p) =>
    p.state === "no report"
      ? [p.process, p.state, "–", "–", "–", "–", "–"]
      : [p.process, p.state, p.rate_hz.toFixed(1), `${p.overruns}`, `${p.steps_skipped}`, p.late_us_max.toFixed(0), p.age_s.toFixed(1)],
  );
  fill("processes", processes, (row, r) => row.classList.toggle("bad", now.processes[r].state === "silent"));
  const topics = now.topics.map((t) => [
    t.topic, t.source, t.rate_hz.toFixed(1), `${t.received}`, `${t.gaps}`, t.age_s.toFixed(2), t.late ? "late" : "ok",
  ]);
  fill("topics", topics, (row, r) => row.classList.toggle("bad", now.topics[r].late));
  const missing = now.topics.filter((t) => t.topic === "tick" || t.topic === "state").reduce((n, t) => n + t.gaps, 0);
  set("missing", missing ? `${missing} ticks and states did not reach this page; a log may have them.` : "");
  for (const cell of byId("status-counts").querySelectorAll("td")) setText(cell, `${now.status_counts[cell.dataset.count]}`);
  const effects = now.links.map((l) => `${l.link}: ${l.count} ${l.effect}`);
  const unfit = now.mismatched_messages ? [`${now.mismatched_messages} messages do not fit the scenario`] : [];
  set("links", [...effects, ...unfit].join(" · "));
}

let newestEvent = -1;

export function forgetEvents() {
  newestEvent = -1;
  byId("events")?.replaceChildren();
}

function showEvents(events) {
  const list = byId("events");
  for (const event of events) {
    if (event.number <= newestEvent) continue;
    newestEvent = event.number;
    const item = document.createElement("li");
    item.className = event.severity;
    const severity = document.createElement("span");
    severity.className = "severity";
    severity.textContent = event.severity;
    item.append(severity, ` ${event.source}: ${event.text}`);
    list.prepend(item);
    while (list.children.length > 50) list.lastChild.remove();
  }
}
