// Rows of the engineers' table of links: settings in force and counts of messages.

/** @param {number} value */
const short = (value) => value.toFixed(1).replace(/\.0$/, "");

/** Returns effects of a link other than delay, jitter and loss, in words; empty without any.
 * @param {any} settings */
export function otherEffects(settings) {
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

/** @param {any} state
 * @returns {string[]} */
export function linkRow({ link, settings, counts }) {
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
