// The WebSocket of frames: connects, detects silence, connects again, and reports in words what is wrong.

const RETRY_MS = 1000;
const RETRY_AFTER_END_MS = 5000;
const SILENCE_MS = 2000;

/** @typedef {{onFrame: (frame: import("./types.js").Frame) => void, onState: (state: string, text: string) => void}} Listener */

/** @param {Listener} listener */
export function connect({ onFrame, onState }) {
  let ended = false;
  let lastFrameAt = performance.now();
  /** @type {WebSocket} */
  let socket;

  function open() {
    socket = new WebSocket(socketAddress("/live"));
    socket.onmessage = (message) => {
      lastFrameAt = performance.now();
      const frame = JSON.parse(message.data);
      ended = frame.now.liveness.state === "ended";
      onFrame(frame);
    };
    socket.onclose = (closing) => {
      if (!ended) {
        const reason = closing.reason ? ` (${closing.reason})` : "";
        onState("lost", `Connection lost${reason}: the run has ended, or the dashboard does not answer. Trying again.`);
      }
      setTimeout(open, ended ? RETRY_AFTER_END_MS : RETRY_MS);
    };
  }

  setInterval(() => {
    const silentFor = performance.now() - lastFrameAt;
    if (!ended && socket.readyState === WebSocket.OPEN && silentFor > SILENCE_MS) {
      onState("lost", `The dashboard has sent nothing for ${(silentFor / 1000).toFixed(0)} s.`);
    }
  }, 500);

  open();
}

/** Returns the address of a WebSocket of this server.
 * @param {string} path */
export function socketAddress(path) {
  return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${path}`;
}
