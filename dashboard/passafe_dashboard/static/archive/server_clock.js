// The server's wall clock: files carry its times, and the browser's clock may be wrong by hours.

let ahead_s = 0;

/** Notes the server's clock from an answer.
 * @param {{headers: {get: (name: string) => string | null}}} answer
 * @param {number} [now_ms] the browser's clock */
export function noteClock(answer, now_ms = Date.now()) {
  const server_ms = Date.parse(answer.headers.get("date") ?? "");
  if (Number.isFinite(server_ms)) ahead_s = (server_ms - now_ms) / 1000;
}

/** Returns the server's Unix time.
 * @param {number} [now_ms] the browser's clock */
export function serverSeconds(now_ms = Date.now()) {
  return now_ms / 1000 + ahead_s;
}
