// The WebSocket: connects, detects silence, connects again, and reports in words what is wrong.
const RETRY_MS = 1000;
const RETRY_AFTER_END_MS = 5000;
const SILENCE_MS = 2000;

export function connect({ onFrame, onState }) {
  let ended = false;
  let lastFrameAt = performance.now();
  let socket = null;

  function open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    socket = new WebSocket(`${scheme}://${location.host}/live`);
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
