// The links: a table of their states, and a form that changes delay, jitter and loss of one.
// The form is filled with what is in force; the server's answer is shown beside it.
import { fill, number, setText } from "./readouts.js";

const byId = (id) => document.getElementById(id);
const form = byId("link-form");
const fields = { delay_s: ["link-delay", 1e3], jitter_s: ["link-jitter", 1e3], loss: ["link-loss", 1e2] };

let states = [];
let filled = null;

const short = (value) => number(value, 1).replace(/\.0$/, "");

// Effects of a link other than delay, jitter and loss, in words; empty without any.
function otherEffects(settings) {
  const effects = [];
  if (settings.distribution !== "uniform") effects.push(settings.distribution);
  if (settings.correlation) effects.push(`correlation ${settings.correlation}`);
  if (!settings.reorder) effects.push("in order");
  if (settings.burst_enter || settings.burst_loss_good) effects.push(`bursts ${settings.burst_enter} in, ${settings.burst_leave} out`);
  if (settings.duplicate) effects.push(`copies ${short(100 * settings.duplicate)} %`);
  if (settings.corrupt) effects.push(`flipped bits ${short(100 * settings.corrupt)} %`);
  if (settings.rate_hz) effects.push(`${short(settings.rate_hz)}/s, queue ${settings.queue}`);
  if (settings.trace_opportunities) effects.push(`trace of ${settings.trace_opportunities} times`);
  if (settings.network) effects.push(settings.network);
  if (settings.outages.length) effects.push(`${settings.outages.length} outages`);
  return effects.join(", ");
}

function row({ link, settings, counts }) {
  if (!settings) return [link, ...Array(12).fill("–")];
  const { entered, delivered, dropped_loss, dropped_queue, dropped_outage, duplicated, corrupted, in_flight } = counts;
  const numbers = [entered, delivered, dropped_loss, dropped_queue, dropped_outage, duplicated, corrupted, in_flight];
  return [
    link,
    short(1e3 * settings.delay_s),
    short(1e3 * settings.jitter_s),
    short(1e2 * settings.loss),
    otherEffects(settings),
    ...numbers.map((count) => `${count}`),
  ];
}

export function showLinks(now) {
  if (!form) return;
  states = now.link_states;
  fill("link-states", states.map(row));
  if (filled === null) fillForm();
}

function fillForm() {
  const name = byId("link-name").value;
  const settings = states.find((state) => state.link === name)?.settings;
  filled = settings ? name : null;
  for (const [field, [id, scale]] of Object.entries(fields)) {
    byId(id).value = settings ? Number((scale * settings[field]).toPrecision(9)) : "";
  }
}

async function requestChange(event) {
  event.preventDefault();
  const name = byId("link-name").value;
  const wanted = Object.entries(fields).map(([field, [id, scale]]) => [field, byId(id).valueAsNumber / scale]);
  const answer = byId("link-answer");
  setText(answer, "requesting …");
  try {
    const response = await fetch(`/api/links/${encodeURIComponent(name)}`, {
      method: "PUT",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(Object.fromEntries(wanted)),
    });
    setText(answer, answerText(name, response.ok, await response.json()));
  } catch (error) {
    setText(answer, `${name}: the dashboard does not answer (${error.message})`);
  }
}

function answerText(name, ok, body) {
  if (ok) {
    const { delay_s, jitter_s, loss } = body.settings;
    return `${name}: now ${short(1e3 * delay_s)} ms, jitter ${short(1e3 * jitter_s)} ms, loss ${short(1e2 * loss)} %`;
  }
  const { detail } = body;
  const reasons = Array.isArray(detail) ? detail.map(({ loc, msg }) => `${loc.slice(1).join(".")} ${msg}`.trim()) : [detail];
  return `${name}: refused: ${reasons.join("; ")}`;
}

form?.addEventListener("submit", requestChange);
byId("link-name")?.addEventListener("change", fillForm);
