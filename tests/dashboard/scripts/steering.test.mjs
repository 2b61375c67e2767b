// From hands to commands: stick and clutch, keys, gamepad, shares of each axis, and the age of a command.

import assert from "node:assert/strict";
import { test } from "node:test";

const live = "../../../dashboard/passafe_dashboard/static/live";
const { Stick, inDisk, withoutDeadZone } = await import(`${live}/stick.js`);
const { SteeringKeys } = await import(`${live}/keys.js`);
const { BUTTONS, GamepadReader } = await import(`${live}/gamepad.js`);
const { axisShares, firstEngaged } = await import(`${live}/shares.js`);
const { steerMessage } = await import(`${live}/drive_socket.js`);

/** Compares numbers but for their rounding. */
function near(actual, expected) {
  assert.equal(actual.length, expected.length);
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-12, `${actual} is not ${expected}`));
}

test("a stick begins at zero wherever it is taken hold of", () => {
  const stick = new Stick();
  stick.press([0.7, -0.2]);
  near(stick.value, [0, 0]);
  stick.move([1.0, 0.2]);
  near(stick.value, [0.3, 0.4]);
});

test("a stick goes no further than a full command", () => {
  const stick = new Stick();
  stick.press([0, 0]);
  stick.move([30, 40]);
  near(stick.value, [0.6, 0.8]);
  near(inDisk([0.1, 0.2]), [0.1, 0.2]);
});

test("letting go is zero at once", () => {
  const stick = new Stick();
  stick.press([0, 0]);
  stick.move([0.5, 0]);
  stick.release();
  near(stick.value, [0, 0]);
  assert.equal(stick.engaged, false);
  stick.move([0.9, 0]);
  near(stick.value, [0, 0]);
});

test("the clutch lets the hand move without the command, and goes on without a jump", () => {
  const stick = new Stick();
  stick.press([0, 0]);
  stick.move([0.5, 0]);
  stick.clutch(true);
  stick.move([-0.8, 0.3]);
  near(stick.value, [0.5, 0]);
  stick.clutch(false);
  near(stick.value, [0.5, 0]);
  stick.move([-0.8, 0.3]);
  near(stick.value, [0.5, 0]);
  stick.move([-0.7, 0.3]);
  near(stick.value, [0.6, 0]);
});

test("a dead zone is continuous at its edge and keeps the full deflection", () => {
  near(withoutDeadZone([0.1, 0], 0.12), [0, 0]);
  near(withoutDeadZone([0, 1], 0.12), [0, 1]);
  assert.ok(withoutDeadZone([0.1201, 0], 0.12)[0] < 1e-3);
});

test("a held key pushes further and further, a released one lets go at once", () => {
  const keys = new SteeringKeys(1);
  keys.set("ArrowRight", true);
  assert.equal(keys.engaged, true);
  keys.step(0.1);
  near(keys.values[0], [0.3, 0]);
  for (let i = 0; i < 10; i += 1) keys.step(0.1);
  near(keys.values[0], [1, 0]);
  keys.set("ArrowRight", false);
  assert.equal(keys.engaged, false);
  keys.step(0.01);
  near(keys.values[0], [0, 0]);
});

test("two keys push along the diagonal, and opposite ones not at all", () => {
  const keys = new SteeringKeys(1);
  keys.set("KeyD", true);
  keys.set("ArrowUp", true);
  near(keys.target(0), [Math.SQRT1_2, Math.SQRT1_2]);
  keys.set("ArrowDown", true);
  near(keys.target(0), [1, 0]);
});

test("with two sticks each group of keys steers its own", () => {
  const keys = new SteeringKeys(2);
  keys.set("ArrowUp", true);
  keys.set("KeyA", true);
  near(keys.target(0), [0, 1]);
  near(keys.target(1), [-1, 0]);
});

test("a clutch holds the value of keys", () => {
  const keys = new SteeringKeys(1);
  keys.set("ArrowRight", true);
  keys.step(0.1);
  keys.step(0.1, true);
  near(keys.values[0], [0.3, 0]);
  keys.releaseAll();
  near(keys.values[0], [0, 0]);
});

/** Returns a gamepad as the browser describes it. */
function gamepad(axes, ...held) {
  return [null, { axes, buttons: Array.from({ length: 16 }, (_, i) => ({ pressed: held.includes(i) })) }];
}

test("a gamepad steers up with its stick forward, and only while the dead-man is held", () => {
  const reader = new GamepadReader();
  const idle = reader.read(gamepad([0, -1, 0, 0]), 1);
  assert.equal(idle.engaged, false);
  const held = reader.read(gamepad([0, -1, 0, 0], BUTTONS.dead_man), 1);
  assert.equal(held.engaged, true);
  near(held.values[0], [0, 1]);
});

test("a press of a gamepad's stop is reported once", () => {
  const reader = new GamepadReader();
  assert.equal(reader.read(gamepad([0, 0], BUTTONS.stop), 1).stop, true);
  assert.equal(reader.read(gamepad([0, 0], BUTTONS.stop), 1).stop, false);
  reader.read(gamepad([0, 0]), 1);
  assert.equal(reader.read(gamepad([0, 0], BUTTONS.stop), 1).stop, true);
  assert.equal(reader.read([null], 1).connected, false);
});

test("the first source that is engaged steers; nobody's command is zero", () => {
  const idle = { engaged: false, values: [[1, 1]] };
  const keys = { engaged: true, values: [[0.5, 0]] };
  assert.equal(firstEngaged([idle, keys], 1), keys);
  assert.deepEqual(firstEngaged([idle], 1), { engaged: false, values: [[0, 0]] });
});

test("shares go to the axes of each stick, within a full command", () => {
  near(axisShares([[0.5, -2], [0.25, 1]], [[0, 1], [2]], 3), [0.5, -1, 0.25]);
  near(axisShares([], [[0, 1]], 2), [0, 0]);
});

test("a command says under which clock it was made and how long ago that came", () => {
  const message = steerMessage(7, [1, 0], true, { server_ms: 1000, received_ms: 50 }, 62);
  assert.deepEqual(message, { type: "steer", number: 7, shares: [1, 0], engaged: true, echo_ms: 1000, held_ms: 12 });
});
