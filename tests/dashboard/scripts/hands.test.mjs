// Hands that do what nobody planned: a second finger, another button, a gamepad that goes, a screen that is too fast.

import assert from "node:assert/strict";
import { test } from "node:test";

const statics = "../../../dashboard/passafe_dashboard/static";
const { DriveSocket } = await import(`${statics}/live/drive_socket.js`);
const { BUTTONS, GamepadReader } = await import(`${statics}/live/gamepad.js`);
const { Pad } = await import(`${statics}/live/pad.js`);
const { timeAgo } = await import(`${statics}/archive/page_parts.js`);
const { noteClock } = await import(`${statics}/archive/server_clock.js`);

/** A canvas that takes events. */
class Canvas extends EventTarget {
  style = {};
  setAttribute() {}
  setPointerCapture() {}
}

/** Returns a pad of 150 px, whose reach is 55 px, and what sends it an event. */
function pad() {
  globalThis.document = { createElement: () => new Canvas() };
  const made = new Pad(0, "Stick", [0, 1], 150, { press: () => true, change: () => {} });
  const send = (type, fields = {}) => {
    const event = Object.assign(new Event(type, { cancelable: true }), { pointerId: 1, button: 0, offsetX: 75, offsetY: 75 }, fields);
    made.canvas.dispatchEvent(event);
    return event;
  };
  return { stick: made.stick, send };
}

test("a second finger on the stick moves nothing and ends nothing", () => {
  const { stick, send } = pad();
  send("pointerdown");
  send("pointermove", { offsetX: 130 });
  send("pointerdown", { pointerId: 2, offsetX: 20 });
  send("pointermove", { pointerId: 2, offsetX: 75 });
  assert.deepEqual(stick.value, [1, 0]);
  send("pointerup", { pointerId: 2 });
  assert.equal(stick.engaged, true);
  send("pointercancel");
  assert.equal(stick.engaged, false);
  assert.deepEqual(stick.value, [0, 0]);
});

test("only the first button of a mouse holds the stick, and a long press opens no menu", () => {
  const { stick, send } = pad();
  send("pointerdown", { button: 2 });
  assert.equal(stick.engaged, false);
  assert.equal(send("contextmenu").defaultPrevented, true);
});

const buttons = (...held) => Array.from({ length: 16 }, (_, i) => ({ pressed: held.includes(i) }));

test("of two gamepads that with its dead-man held steers, and both stop", () => {
  const reader = new GamepadReader();
  const idle = { axes: [0, 1], buttons: buttons() };
  const held = reader.read([idle, { axes: [1, 0], buttons: buttons(BUTTONS.dead_man) }], 1);
  assert.equal(held.engaged, true);
  assert.equal(held.values[0][0], 1);
  assert.equal(reader.read([idle, { axes: [0, 0], buttons: buttons(BUTTONS.stop) }], 1).stop, true);
});

test("a gamepad that comes back with its stop held stops again", () => {
  const reader = new GamepadReader();
  const pressed = { axes: [0, 0], buttons: buttons(BUTTONS.stop) };
  reader.read([pressed], 1);
  assert.equal(reader.read([null], 1).engaged, false);
  assert.equal(reader.read([pressed], 1).stop, true);
});

/** Returns a socket that drives, with the commands that it sent. */
function driving(fields = {}) {
  globalThis.WebSocket = { OPEN: 1 };
  const sent = [];
  const socket = new DriveSocket({ onDriver: () => {}, onRefused: () => {} });
  Object.assign(socket, { you: true, clock: { server_ms: 5000, received_ms: 0 } });
  socket.socket = { readyState: 1, bufferedAmount: 0, send: (text) => sent.push(JSON.parse(text)), ...fields };
  return { socket, sent };
}

test("a screen of 240 Hz and the timer together send no more than the server takes", () => {
  const { socket, sent } = driving();
  for (let at = 0; at < 1000; at += 1000 / 240) socket.steer([at / 1000, 0], true, at);
  for (let at = 0; at < 1000; at += 16) socket.steer([0, 0], true, at);
  assert.ok(sent.length > 60 && sent.length <= 126, `${sent.length} commands`);
});

test("letting go is never held back", () => {
  const { socket, sent } = driving();
  socket.steer([1, 0], true, 10);
  socket.steer([0, 0], false, 11);
  assert.deepEqual(sent.map(({ engaged }) => engaged), [true, false]);
});

test("while nothing gets through no command waits", () => {
  const full = driving({ bufferedAmount: 200 });
  full.socket.steer([1, 0], true, 10);
  const silent = driving();
  silent.socket.steer([1, 0], true, 1500);
  assert.deepEqual([full.sent, silent.sent], [[], []]);
});

test("the age of a log is told by the server's clock", () => {
  const served = "Tue, 01 Dec 2026 12:00:00 GMT";
  noteClock({ headers: { get: () => served } }, Date.parse(served) - 5 * 3600e3);
  assert.equal(timeAgo(Date.now() / 1000 + 5 * 3600 - 300), "5 min ago");
  noteClock({ headers: { get: () => null } });
  assert.equal(timeAgo(Date.now() / 1000 + 5 * 3600 - 300), "5 min ago");
});
