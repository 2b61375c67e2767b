// The WebSocket of control: asks to drive, sends commands with their age, receives who drives.

import { socketAddress } from "./connection.js";

const RETRY_MS = 1000;
const LEAST_APART_MS = 8; // a screen may report the hand 240 times a second, and the server takes 200 messages
const SILENT_MS = 1000;

/** @typedef {{you: boolean, driver: import("./types.js").Driver, reason: string}} DriverNews */

/** The server's clock as last received, and when.
 * @typedef {{server_ms: number, received_ms: number}} Clock */

/** Returns a command for the server. It carries the newest clock of the server that it was made under and the time
 * since, so that the server knows its age without a clock in common.
 * @param {number} number
 * @param {number[]} shares
 * @param {boolean} engaged
 * @param {Clock} clock
 * @param {number} now_ms */
export function steerMessage(number, shares, engaged, clock, now_ms) {
  const held_ms = Math.max(now_ms - clock.received_ms, 0);
  return { type: "steer", number, shares, engaged, echo_ms: clock.server_ms, held_ms };
}

export class DriveSocket {
  /** @param {{onDriver: (news: DriverNews) => void, onRefused: (text: string) => void}} listener */
  constructor(listener) {
    this.listener = listener;
    this.you = false;
    this.number = 0;
    this.sent = { at: -Infinity, engaged: false };
    /** @type {Clock | null} */
    this.clock = null;
    /** @type {WebSocket | null} */
    this.socket = null;
  }

  /** Connects, and again whenever the connection is lost. */
  open() {
    if (this.socket && this.socket.readyState !== WebSocket.CLOSED) return;
    this.socket = new WebSocket(socketAddress("/drive"));
    this.socket.onmessage = (message) => this.receive(JSON.parse(message.data), performance.now());
    this.socket.onclose = () => {
      this.clock = null;
      if (this.you) this.tell({ you: false, driver: null, reason: "the connection was lost" });
      setTimeout(() => this.open(), RETRY_MS);
    };
  }

  /** @param {any} message
   * @param {number} at */
  receive(message, at) {
    if (message.type === "clock") this.clock = { server_ms: message.server_ms, received_ms: at };
    else if (message.type === "driver") this.tell(message);
    else if (message.type === "refused") this.listener.onRefused(`${message.what}: got ${message.got}, allowed ${message.allowed}`);
  }

  /** @param {DriverNews} news */
  tell(news) {
    this.you = news.you;
    this.listener.onDriver(news);
  }

  get usable() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** @param {boolean} over whether to take the controls from somebody */
  take(over) {
    this.send({ type: "take", over });
  }

  release() {
    if (this.you) this.send({ type: "release" });
  }

  /** Lets the scenario's own source drive. */
  script() {
    this.send({ type: "script" });
  }

  /** Sends a command, unless one has just been sent, or nothing gets through: late ones would only come in a flood.
   * @param {number[]} shares
   * @param {boolean} engaged
   * @param {number} [now_ms] */
  steer(shares, engaged, now_ms = performance.now()) {
    if (!this.you || !this.clock || this.socket?.bufferedAmount || now_ms - this.clock.received_ms > SILENT_MS) return;
    if (engaged === this.sent.engaged && now_ms - this.sent.at < LEAST_APART_MS) return;
    this.sent = { at: now_ms, engaged };
    this.number += 1;
    this.send(steerMessage(this.number, shares, engaged, this.clock, now_ms));
  }

  /** @param {object} message */
  send(message) {
    if (this.usable) this.socket?.send(JSON.stringify(message));
  }
}
