// Moves rows of frames into the tables that the charts were made with (dashboard/figures/page.py).
function table(name) {
  return globalThis.Bokeh?.documents[0]?.get_model_by_name(name) ?? null;
}

export function chartsReady() {
  return table("robot") !== null;
}

export function startOver() {
  for (const name of ["ticks", "states"]) {
    const source = table(name);
    source.data = Object.fromEntries(source.columns().map((column) => [column, [NaN]]));
  }
}

export function applyRows(name, columns, rows, keep) {
  if (rows.length === 0) return;
  const fresh = Object.fromEntries(columns.map((column, index) => [column, rows.map((row) => row[index] ?? NaN)]));
  table(name).stream(fresh, keep);
}

export function moveRobot(x) {
  table("robot").data = { p1_m: [x[0]], p2_m: [x[1]] };
}
