// Requests to the server and their answers in words.

/** @param {any} detail of a refusal: a sentence, or what pydantic found */
export function refusalText(detail) {
  if (!Array.isArray(detail)) return String(detail ?? "no reason was given");
  return detail.map(({ loc, msg }) => `${(loc ?? []).slice(1).join(".")} ${msg}`.trim()).join("; ");
}

/** Sends JSON; returns the answer's body, or a sentence of what went wrong.
 * @param {string} method
 * @param {string} path
 * @param {unknown} [body]
 * @returns {Promise<{ok: true, body: any} | {ok: false, reason: string}>} */
export async function request(method, path, body) {
  try {
    const response = await fetch(path, {
      method,
      headers: { "Content-Type": "application/json" },
      body: body === undefined ? undefined : JSON.stringify(body),
    });
    const text = await response.text();
    const answer = text ? JSON.parse(text) : null;
    if (response.ok) return { ok: true, body: answer };
    return { ok: false, reason: refusalText(answer?.detail) };
  } catch (error) {
    return { ok: false, reason: `the dashboard does not answer (${error instanceof Error ? error.message : error})` };
  }
}
