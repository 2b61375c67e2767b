// Moves rows of frames into the tables that the charts were made with (dashboard/passafe_dashboard/charts/live_charts.py).
function table(name) {
  return globalThis.Bokeh?.documents[0]?.get_model_by_name(name) ?? null;
}

export function chartsReady() {
  return table("ticks") !== null;
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

// A state begins with the positions, in the order of the table's columns.
export function moveRobot(columns, x) {
  const robot = table("robot");
  if (robot) robot.data = Object.fromEntries(columns.map((column, index) => [column, [x[index] ?? NaN]]));
}

const unmoved = new Map();

// Tables of obstacles hold places before motion; a region to stay in has its border in a second table.
export function moveObstacles(moved) {
  for (const [name, [d1, d2]] of Object.entries(moved)) {
    for (const each of [name, `${name}_border`]) {
      const source = table(each);
      if (!source) continue;
      if (!unmoved.has(each)) unmoved.set(each, source.data);
      const { p1_m, p2_m } = unmoved.get(each);
      source.data = { p1_m: Array.from(p1_m, (p) => p + d1), p2_m: Array.from(p2_m, (p) => p + d2) };
    }
  }
}
