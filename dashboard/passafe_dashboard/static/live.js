// The live page: one WebSocket in, charts and numbers out.
// Frames are applied in animation frames, so a hidden page does no work and catches up when it is shown.
// After a drawing comes a rest of the same length: a control loop may share the processor.
import { applyRows, chartsReady, moveObstacles, moveRobot, startOver } from "./charts.js";
import { connect } from "./connection.js";
import { showLinks } from "./links.js";
import { showStop } from "./stop.js";
import { forgetEvents, showConnection, showLost, showState } from "./readouts.js";

const setup = JSON.parse(document.getElementById("setup").textContent);
const NUMBERS_EVERY_MS = 200;
const REST_FOR_EACH_MS = 1;

let pending = { restart: false, ticks: [], states: [], lost: 0, now: null };
let scheduled = false;
let numbersShownAt = -Infinity;
let drawn = null;

function receive(frame) {
  if (frame.layout !== setup.layout) {
    location.reload();
    return;
  }
  if (frame.restart) pending = { restart: true, ticks: [], states: [], lost: 0, now: null };
  for (const table of ["ticks", "states"]) {
    pending[table].push(...frame.tables[table]);
    pending[table].splice(0, pending[table].length - setup.rows);
  }
  pending.lost += frame.lost;
  pending.now = frame.now;
  showConnection(frame.now.liveness.state, frame.now.liveness.text);
  if (!scheduled) {
    scheduled = true;
    requestAnimationFrame(draw);
  }
}

function restAfter(begin) {
  // The next animation frame comes when what was drawn is on the screen.
  requestAnimationFrame(() => {
    const rest = (performance.now() - begin) * REST_FOR_EACH_MS;
    setTimeout(() => requestAnimationFrame(draw), rest);
  });
}

function draw(at) {
  const begin = performance.now();
  if (pending.now === drawn) {
    scheduled = false;
    return;
  }
  const { now, lost } = pending;
  drawn = now;
  if (chartsReady()) {
    if (pending.restart) {
      startOver();
      forgetEvents();
    }
    for (const table of ["ticks", "states"]) {
      applyRows(table, setup.columns[table], pending[table], setup.rows);
    }
    if (now.plant) moveRobot(setup.columns.robot, now.plant.x);
    moveObstacles(now.plant?.moved_m ?? setup.moved_m);
    pending = { restart: false, ticks: [], states: [], lost: 0, now };
  }
  if (lost) showLost(lost);
  if (at - numbersShownAt >= NUMBERS_EVERY_MS || now.liveness.state === "ended") {
    numbersShownAt = at;
    showState(now);
    showLinks(now);
    showStop(now);
  }
  restAfter(begin);
}

connect({ onFrame: receive, onState: showConnection });
