// Lists and maps of logs and experiments: names in addresses, sizes, times, changes of a what-if, rows of a map.

import assert from "node:assert/strict";
import { test } from "node:test";

const archive = "../../../dashboard/passafe_dashboard/static/archive";
const { sizeText, timeAgo } = await import(`${archive}/page_parts.js`);
const { pathOf } = await import(`${archive}/server.js`);
const { sizeOf } = await import(`${archive}/start_experiment.js`);
const { acrossOf, cellText, rowsOf, shareWord } = await import(`${archive}/sweep_map.js`);
const { changesOf, numbersOf } = await import(`${archive}/what_if.js`);

test("a name becomes an address that keeps its folders", () => {
  assert.equal(pathOf("delay/logs/ü #1?.mcap"), "delay/logs/%C3%BC%20%231%3F.mcap");
});

test("sizes and times are those that a person reads", () => {
  assert.deepEqual([999, 2.5e6, 3e9].map(sizeText), ["1.0 kB", "2.5 MB", "3.00 GB"]);
  assert.deepEqual([990, 700, -9000, -1e6].map((s) => timeAgo(s, 1000)), ["just now", "5 min ago", "2 h ago", "1969-12-20"]);
});

test("the form of a what-if becomes values of a scenario", () => {
  const form = new Map(Object.entries({ link: "plant-to-filter", delay_ms: "150", loss_percent: "7", mode: "safe", law: "" }));
  form.set("key", "filter.k_i").set("value", "5");
  assert.deepEqual(changesOf(form), {
    "links.plant-to-filter.delay_s": 0.15,
    "links.plant-to-filter.loss": 0.07,
    "filter.mode": "safe",
    "filter.k_i": 5,
  });
  assert.deepEqual(changesOf(new Map()), {});
  assert.throws(() => changesOf(new Map([["delay_ms", "1"]])), /Which link/);
  assert.throws(() => changesOf(new Map([["value", "1"]])), /Which key/);
});

test("a value is a number, a list or a word", () => {
  const value = (text) => changesOf(new Map([["key", "filter.k"], ["value", text]]))["filter.k"];
  assert.deepEqual([value("1e-3"), value("[1, 2]"), value("true"), value("tank")], [1e-3, [1, 2], true, "tank"]);
});

test("numbers that may be changed are offered by name", () => {
  const scenario = { rate_hz: 1000, filter: { k_i: 20, barriers: [{ radius: 1 }], mode: "both" }, operator: { gain: 1 } };
  assert.deepEqual(numbersOf(scenario), ["filter.k_i", "filter.barriers.0.radius"]);
});

const probe = (runs, broken, low) => ({ probe: null, runs, errors: 0, breaking: { safe: broken }, low: { h: low }, high: { h: 9 } });
const cell = (number, variant, values, probes) => ({ number, variant, values, probes, boundaries: {} });
const axes = [{ name: "loss", values: ["0", "0.1"] }, { name: "delay", values: ["0", "1", "2"] }];

test("the longest axis runs across, all others down", () => {
  assert.equal(acrossOf(axes), 1);
  assert.equal(acrossOf([]), -1);
  const cells = ["off", "both"].flatMap((variant) =>
    axes[0].values.flatMap((loss) => axes[1].values.map((delay, k) => cell(k, variant, [loss, delay], []))),
  );
  const rows = rowsOf(cells, axes, ["off", "both"]);
  assert.deepEqual(rows.map(({ head }) => head), ["off, loss 0", "off, loss 0.1", "both, loss 0", "both, loss 0.1"]);
  assert.ok(rows.every(({ cells: found }) => found.length === 3));
});

test("a cell says how many runs break, and what is to come", () => {
  const map = { metric: "h", worstIsHigh: false, seeds: 3, bisected: false };
  const some = cell(0, "off", [], [probe(2, 1, -0.5)]);
  assert.equal(shareWord(some, "safe"), "some");
  assert.deepEqual(cellText(some, "safe", map), { main: "−0.500", note: "1 of 2 break, 1 to come" });
  assert.deepEqual(cellText(some, "safe", { ...map, worstIsHigh: true }).main, "9.00");
  const none = cell(0, "off", [], []);
  assert.equal(shareWord(none, "safe"), "unknown");
  assert.equal(cellText(none, "safe", map).main, "–");
  assert.equal(shareWord(cell(0, "off", [], [probe(3, 3, -1)]), "safe"), "all");
});

test("the size of an experiment is said in words", () => {
  const offer = { source: "file", experiment: "x", title: "", cells: 4, seeds: 2, most_runs: 8, trouble: "" };
  assert.equal(sizeOf(offer, 3, 100), "4 cells, 12 runs");
  assert.equal(sizeOf({ ...offer, cells: 1, most_runs: 20 }, 1, 100), "1 cell, up to 10 runs");
  assert.match(sizeOf(offer, 30, 100), /120 runs: more than the 100 of the page/);
  assert.equal(sizeOf({ ...offer, trouble: "no metric" }, 1, 100), "no metric");
});
