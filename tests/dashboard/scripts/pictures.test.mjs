// What the page draws and writes: view of the plane, held-back directions, bars, sliders, texts, rows that wait.

import assert from "node:assert/strict";
import { test } from "node:test";

const live = "../../../dashboard/passafe_dashboard/static/live";
const { Camera, MARGIN_PX, widened } = await import(`${live}/camera.js`);
const { DialScale, askedAndAllowed, cuts, decisionInForce } = await import(`${live}/input_dial.js`);
const { barSpan, shownGaps } = await import(`${live}/gap_bars.js`);
const { boxAround, readableNames } = await import(`${live}/outline_names.js`);
const { QUANTITIES, settingText, sliderOf, valueOf } = await import(`${live}/network_panel.js`);
const { ageText } = await import(`${live}/delays_panel.js`);
const { afterClearText, driverText, leaseText, recordingText } = await import(`${live}/driver_panel.js`);
const { heldShare } = await import(`${live}/feel.js`);
const { FrameQueue } = await import(`${live}/frame_queue.js`);
const { LiveTable } = await import(`${live}/live_table.js`);
const { certificateText } = await import(`${live}/engineer_sheet.js`);
const { number } = await import(`${live}/number_table.js`);
const { refusalText } = await import(`${live}/requests.js`);
const { angleText, jointRange } = await import(`${live}/joint_scene.js`);
const { processText } = await import(`${live}/process_panel.js`);
const { PlaneScene, numbersOf } = await import(`${live}/plane_scene.js`);
const { ShownLook } = await import(`${live}/shown_look.js`);
const { seen } = await import(`${live}/space_scene.js`);
const { lastText } = await import(`${live}/run_panel.js`);
const { otherEffects } = await import(`${live}/link_rows.js`);

test("a view holds its bounds with room for a dial, in the middle and to scale", () => {
  const camera = new Camera([[-3, -2], [3, 2]]);
  assert.equal(camera.aim(600 + 2 * MARGIN_PX, 400 + 2 * MARGIN_PX, []), true);
  assert.deepEqual(camera.pixel(0, 0), [300 + MARGIN_PX, 200 + MARGIN_PX]);
  assert.deepEqual(camera.pixel(-3, 2), [MARGIN_PX, MARGIN_PX]);
  assert.equal(camera.aim(600 + 2 * MARGIN_PX, 400 + 2 * MARGIN_PX, [[1, 1]]), false);
});

/** Returns the name of a pillar at (x, 0) with radius 10, pixels. */
function pillar(text, x, { width = 60, nearest = false } = {}) {
  return { text, width, nearest, outline: boxAround([[x - 10, -10], [x + 10, 10]]) };
}

test("names are written where they cover no other and no neighbour", () => {
  const written = (names) => readableNames(names).map(({ text }) => text);
  assert.deepEqual(written([pillar("a", 0), pillar("b", 100)]), ["a", "b"]);
  assert.deepEqual(written([pillar("a", 0), pillar("b", 35)]), []);
  assert.deepEqual(written([pillar("a", 0, { width: 16 }), pillar("b", 35, { width: 90 })]), ["a"]);
  assert.deepEqual(written([pillar("a", 0), pillar("b", 55)]), ["a"]);
});

test("the name of the nearest limit is always written", () => {
  const names = [pillar("a", 0), pillar("b", 55, { nearest: true }), pillar("c", 200)];
  assert.deepEqual(readableNames(names).map(({ text }) => text), ["b", "c"]);
});

test("an outline around all others hides none of their names", () => {
  const hall = { text: "hall", width: 30, nearest: false, outline: boxAround([[-500, -500], [500, 500]]) };
  assert.deepEqual(readableNames([hall, pillar("a", 200)]).map(({ text }) => text), ["hall", "a"]);
});

test("a view widens step by step for a robot that leaves it", () => {
  const camera = new Camera([[-1, -1], [1, 1]]);
  camera.aim(500, 500, []);
  const before = camera.scale;
  assert.equal(camera.aim(500, 500, [[9, 0]]), true);
  assert.ok(camera.scale < before && camera.scale > before / 5);
  for (let i = 0; i < 100; i += 1) camera.aim(500, 500, [[9, 0]]);
  assert.ok(camera.pixel(9, 0)[0] < 500 - MARGIN_PX + 1);
  assert.deepEqual(widened([[-1, -1], [1, 1]], [[9, 0]]), [[-1, -1], [9, 1]]);
});

test("what was allowed is the operator's part of the decision", () => {
  const filter = { u_h: [4, 0], u_nominal: [14, 1], u: [11, 1] };
  assert.deepEqual(askedAndAllowed(filter, [0, 1]), { asked: [4, 0], allowed: [1, 0] });
});

test("a decision is drawn only while it drives the robot", () => {
  const filter = { u: [1, 2] };
  const now = (state, phase) => ({ liveness: { state }, plant: { phase }, filter });
  assert.equal(decisionInForce(now("live", "RUNNING")), filter);
  assert.equal(decisionInForce(now("live", "HOLDING")), filter);
  assert.equal(decisionInForce(now("live", "FAIL_SAFE")), null);
  assert.equal(decisionInForce(now("silent", "RUNNING")), null);
  assert.equal(decisionInForce({ liveness: { state: "live" }, plant: null, filter: null }), null);
});

test("a barrier cuts off the directions beyond its margin", () => {
  const held = { name: "wall", point: 0, towards: [1, 0], margin: 3 };
  const [cut] = cuts([held], [2, 0], 10);
  assert.equal(cut.angle, 0);
  assert.ok(Math.abs(Math.cos(cut.half) - 0.5) < 1e-12);
  assert.deepEqual(cuts([{ ...held, margin: 9 }], [2, 0], 10), []);
  assert.equal(cuts([{ ...held, margin: 0 }], [-20, 0], 10)[0].half, Math.PI);
});

test("a dial grows at once with what is asked and shrinks slowly", () => {
  const scale = new DialScale(10);
  assert.equal(scale.follow(14), 14);
  assert.ok(scale.follow(1) > 13);
  assert.equal(new DialScale(10).follow(3), 10);
});

test("bars begin at zero, and a violated one goes to the other side", () => {
  const gap = { name: "a", distance: 0.02, unit: "m", text: "", h: 0, lowest_h: 0, nearest: true };
  const near = barSpan(gap, 0.15);
  assert.equal(near.begin, 0.15);
  assert.ok(Math.abs(near.length - 0.085) < 1e-9);
  assert.equal(barSpan({ ...gap, distance: 100 }, 0.15).length, 0.85);
  const beyond = barSpan({ ...gap, distance: -0.1 }, 0.15);
  assert.ok(beyond.begin < 0.15 && Math.abs(beyond.begin + beyond.length - 0.15) < 1e-12);
});

test("of very many barriers the nearest are shown, in the scenario's order", () => {
  const gaps = [5, 1, 4, 2].map((distance) => ({ name: `${distance}`, distance }));
  assert.deepEqual(shownGaps(gaps, 2).map(({ name }) => name), ["1", "2"]);
  assert.equal(shownGaps(gaps, 4), gaps);
});

test("sliders are finer where values are small, and name what they set", () => {
  assert.equal(valueOf(0, 1000), 0);
  assert.equal(valueOf(100, 1000), 1000);
  assert.equal(valueOf(sliderOf(250, 1000), 1000), 250);
  assert.equal(valueOf(10, 1000), 10);
  assert.equal(settingText(0.25, QUANTITIES.delay_s), "250 ms");
  assert.equal(settingText(0.0125, QUANTITIES.loss), "1.3 %");
  assert.equal(settingText(0.02, QUANTITIES.delay_s, "leo-moving"), "+ 20 ms");
});

test("ages are written as people read them", () => {
  assert.deepEqual([null, undefined, 0.2, 1.6, 250.4, 1500].map(ageText), ["–", "–", "< 1 ms", "2 ms", "250 ms", "1.5 s"]);
});

test("who drives is said in words", () => {
  assert.equal(driverText(null, false, "lag"), "nobody");
  assert.equal(driverText({ page: "3", device: "page" }, false, "lag"), "page 3");
  assert.equal(driverText({ page: "3", device: "page" }, true, "lag"), "you, from this page");
  assert.equal(driverText({ page: null, device: "lag" }, false, "lag"), "the script (lag)");
  assert.equal(driverText({ page: null, device: "keyboard" }, false, "lag"), "the keyboard");
  assert.equal(leaseText({ holder: null, refused: null }), "free");
  assert.equal(leaseText({ holder: "1", device: "page", heartbeat_ms: 900, refused: "2" }), "held by page, silent for 0.9 s; another session is refused");
});

test("recording is what the session says, or else the recorder", () => {
  assert.equal(recordingText({ session: { recording: true, log: "a.mcap" }, processes: [] }), "on, a.mcap");
  assert.equal(recordingText({ session: null, processes: [{ process: "recorder", state: "silent" }] }), "the recorder is silent");
  assert.equal(recordingText({ processes: [] }), "off");
});

test("the held share is of what was asked, and nothing is held of no request", () => {
  assert.equal(heldShare({ u_h: [3, 4], override: { held_back_norm: 2.5 } }), 0.5);
  assert.equal(heldShare({ u_h: [0, 0], override: { held_back_norm: 7 } }), 0);
  assert.equal(heldShare(null), 0);
});

/** Returns a frame with one row. */
function frame(value, restart = false) {
  return { layout: "a", restart, lost: 1, tables: { ticks: [[value]], states: [] }, now: { server_ms: value } };
}

test("frames that wait become one with the newest state and all rows", () => {
  const queue = new FrameQueue(2);
  assert.equal(queue.take(), null);
  for (const value of [1, 2, 3]) queue.add(frame(value));
  const waiting = queue.take();
  assert.deepEqual(waiting.tables.ticks, [[2], [3]]);
  assert.deepEqual([waiting.now.server_ms, waiting.lost, waiting.restart], [3, 3, false]);
  queue.add(frame(4));
  queue.add(frame(5, true));
  assert.deepEqual(queue.take().tables.ticks, [[5]]);
});

test("a table keeps the newest rows and finds values by time", () => {
  const table = new LiveTable(["start_s", "time_s", "h"], 3);
  table.push([[0, 0.1, 5], [0.1, 0.2, 6], [0.2, 0.3, 7], [0.3, 0.4, null]]);
  assert.deepEqual([...table.start], [0.1, 0.2, 0.3]);
  assert.equal(table.newest, 0.4);
  assert.equal(table.has("h"), true);
  assert.equal(table.value("h", 0.1), 6);
  assert.ok(Math.abs(table.value("h", 0.15) - 6.5) < 1e-9);
  assert.deepEqual(table.range("h", 0.25), [7, 7]);
  assert.equal(table.range("h", 0.35), null);
  table.clear();
  assert.ok(Number.isNaN(table.newest));
});

test("a table goes on when the room behind its rows is used up", () => {
  const table = new LiveTable(["start_s", "time_s", "h"], 3);
  for (let i = 0; i < 20; i += 1) table.push([[i, i + 1, 10 * i]]);
  assert.deepEqual([...table.start], [17, 18, 19]);
  assert.deepEqual([...table.end], [18, 19, 20]);
  assert.deepEqual([...table.envelope("h").low], [170, 180, 190]);
  assert.deepEqual([...table.envelope("time_s").low], [18, 19, 20]);
  assert.ok([...table.envelope("not there").low].every(Number.isNaN));
  table.push(Array.from({ length: 9 }, (_, i) => [i, i, i]));
  assert.deepEqual([...table.envelope("h").low], [6, 7, 8]);
});

test("a picture is drawn again when it would look other, or is old", () => {
  const look = new ShownLook();
  const theme = {};
  assert.equal(look.isNew([10, 20], [theme, "words"], 0), true);
  assert.equal(look.isNew([10.01, 20], [theme, "words"], 10), false);
  assert.equal(look.isNew([10.2, 20], [theme, "words"], 20), true);
  assert.equal(look.isNew([10.2, 20], [theme, "other words"], 30), true);
  assert.equal(look.isNew([10.2, 20], [{}, "other words"], 40), true);
  assert.equal(look.isNew([10.2], [theme, "other words"], 50), true);
  assert.equal(look.isNew([10.2], [theme, "other words"], 700), true);
  look.isNew([Number.NaN], [], 800);
  assert.equal(look.isNew([Number.NaN], [], 810), false);
});

test("every arrow and cut counts for how a point looks", () => {
  const dial = { radius: 50, asked: [1, 2], allowed: [3, 4], cuts: [{ angle: 1, half: 0.5, name: "wall" }] };
  const numbers = numbersOf({ here: [5, 6], velocity: [7, 8], dial, known: { at: [9, 10], text: "" } });
  assert.deepEqual(numbers, [5, 6, 7, 8, 50, 1, 2, 3, 4, 50, 25, 9, 10]);
  assert.deepEqual(numbersOf({ here: [5, 6], velocity: null, dial: null, known: null }), [5, 6]);
});

test("an old state is shown where the robot was then, also while nothing new arrives", () => {
  globalThis.ResizeObserver = class { observe() {} };
  const states = { value: (column, at) => (column === "p1_m" ? at : 0) };
  const scene = new PlaneScene({}, {}, { points: 1, bounds: [[0, 0], [10, 10]], outlines: [], velocities: 2 }, states, [1, 1]);
  scene.camera.aim(1000, 1000, []);
  const known = (silent_s) => {
    const ages = { state_ms: 500 + 1000 * silent_s };
    return scene.knownOf({ ages, plant: { time_s: 5 }, topics: [{ topic: "state", age_s: silent_s }] }, 0);
  };
  assert.deepEqual(known(0).at, scene.camera.pixel(4.5, 0));
  assert.deepEqual(known(2).at, known(0).at);
  assert.equal(known(2).text, "2.5 s old");
});

test("numbers of the size of rounding errors are 0, and no program needs no certificate", () => {
  assert.equal(number(-4.39e-14), "0");
  assert.equal(number(null), "–");
  assert.equal(number(-1.40171), "−1.402");
  const none = { solver: "none", accepted: false, primal_residual: 9.77e-299, dual_residual: 0, gap: 0 };
  assert.equal(certificateText(none), "no program was needed");
  assert.equal(certificateText({ ...none, solver: "" }), "no program was needed");
  assert.equal(certificateText({ ...none, solver: "piqp", accepted: true }), "piqp accepted: primal 0, dual 0, gap 0");
});

test("refusals are sentences", () => {
  assert.equal(refusalText([{ loc: ["body", "loss"], msg: "too large" }]), "loss too large");
  assert.equal(refusalText("no demo"), "no demo");
  assert.equal(refusalText(undefined), "no reason was given");
});

test("a joint is shown between its limits, wider while it is beyond them", () => {
  const [low, high] = jointRange({ low: -1, high: 1 }, 1.5);
  assert.ok(low < -1 && high > 1.5);
  const [from, to] = jointRange({ low: null, high: null }, 0);
  assert.ok(from < -Math.PI && to > Math.PI);
});

test("processes, the last run and effects of links are said in words", () => {
  assert.equal(processText({ state: "no report" }), "not running, or no report yet");
  assert.equal(processText({ state: "silent", age_s: 3.21 }), "silent for 3.2 s");
  assert.equal(processText({ state: "ok", rate_hz: 499.9 }), "500 steps a second");
  assert.equal(lastText(null), "");
  assert.equal(lastText({ run: 2, log: "a.mcap", detail: "", outcome: "holds", words: "holds" }), "Run 2: holds");
  assert.equal(lastText({ run: 2, log: null, detail: "ended on request", outcome: "", words: "" }), "Run 2: ended on request");
  const settings = { distribution: "uniform", reorder: true, burst_enter: 0, outages: [], duplicate: 0.02, network: "lte-driving" };
  assert.equal(otherEffects(settings), "copies 2 %, lte-driving");
});

test("a clear says what moves the robot afterwards", () => {
  assert.match(afterClearText({ page: null, device: "waypoints" }, false, "waypoints"), /the script \(waypoints\) drives on at once\.$/);
  assert.match(afterClearText({ page: "3", device: "page" }, true, "waypoints"), /let go of stick and keys, then drive on\.$/);
  assert.match(afterClearText(null, false, "waypoints"), /nobody drives\.$/);
});

test("a process that the demo does not run is not silent", () => {
  const silent = { state: "silent", age_s: 288.8 };
  assert.equal(processText(silent, undefined, true), "not part of this run");
  assert.equal(processText(silent, "running", true), "silent for 288.8 s");
  assert.equal(processText(silent, undefined, false), "silent for 288.8 s");
  assert.equal(processText({ state: "ok", rate_hz: 250 }, "down", true), "down until restarted");
});

test("what a model of a network does is not shown as nothing", () => {
  assert.equal(settingText(0, QUANTITIES.delay_s, "aircraft-bad"), "modelled");
  assert.equal(settingText(0.02, QUANTITIES.delay_s, "aircraft-bad"), "+ 20 ms");
  assert.equal(settingText(0, QUANTITIES.delay_s), "0 ms");
});

test("an old age is read in the unit that suits it", () => {
  assert.deepEqual([999, 55_105, 111_353].map(ageText), ["999 ms", "55.1 s", "2 min"]);
});

test("an angle is never written with a power of ten", () => {
  assert.deepEqual([-6.5e-16, 0.7, -Math.PI / 2].map(angleText), ["0.0°", "40.1°", "−90.0°"]);
});

test("a place in space is seen from the side and from above", () => {
  assert.deepEqual(seen([1, 2, 3], [0, 2]), [1, 3]);
  assert.deepEqual(seen([1, 2, 3], [0, 1]), [1, 2]);
});
