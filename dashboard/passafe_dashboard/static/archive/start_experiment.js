// Starts an experiment: one that comes with passafe, or a file in the runs folder.

import { element, reason } from "./page_parts.js";
import { ask, followJob, pathOf, startJob } from "./server.js";

/** @typedef {{source: string, experiment: string, title: string, cells: number, seeds: number, most_runs: number,
 *   trouble: string}} Offer archive/experiment_models.py */

const GROUPS = [
  { source: "file", label: "In this folder" },
  { source: "shipped", label: "Shipped" },
];

/** Returns in words how much work an experiment is with a number of seeds.
 * @param {Offer} offer
 * @param {number} seeds
 * @param {number} most runs of the largest that may be started */
export function sizeOf(offer, seeds, most) {
  if (offer.trouble) return offer.trouble;
  const runs = Math.round((offer.most_runs / offer.seeds) * seeds);
  const isSearched = offer.most_runs > offer.cells * offer.seeds;
  const text = `${offer.cells} ${offer.cells === 1 ? "cell" : "cells"}, ${isSearched ? "up to " : ""}${runs} runs`;
  return runs > most ? `${text}: more than the ${most} of the page; ask for fewer, or use passafe experiment` : text;
}

/** Fills in the form and shows it. */
export async function offerExperiments() {
  const form = /** @type {HTMLFormElement} */ (element("start"));
  const choice = /** @type {HTMLSelectElement} */ (element("offer"));
  const seeds = /** @type {HTMLInputElement} */ (element("seeds"));
  const cancel = element("start-cancel");
  const answer = element("start-answer");
  /** @type {{offers: Offer[], most_runs: number}} */
  const { offers, most_runs } = await ask("/api/experiment-offers");
  choice.replaceChildren(...GROUPS.flatMap(({ source, label }) => groupOf(offers, source, label)));
  const chosen = () => offers[Number(choice.value)];
  const describe = () => {
    element("offer-title").textContent = chosen().title && `${chosen().title}.`;
    element("offer-size").textContent = sizeOf(chosen(), seeds.valueAsNumber || chosen().seeds, most_runs);
  };
  const choose = () => {
    seeds.value = String(chosen().seeds || 1);
    describe();
  };
  choice.addEventListener("change", choose);
  seeds.addEventListener("input", describe);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const { source, experiment } = chosen();
    const button = /** @type {HTMLButtonElement} */ (form.querySelector("[type=submit]"));
    button.disabled = true;
    try {
      const { job } = await startJob({ kind: "sweep", source, experiment, seeds: seeds.valueAsNumber });
      cancel.hidden = false;
      cancel.onclick = () => ask(`/api/jobs/${job}`, { method: "DELETE" });
      const begun = await followJob(job, ({ text }) => (answer.textContent = text), ({ experiment: name }) => Boolean(name));
      if (!begun.experiment) throw new Error(begun.text);
      location.href = `/experiments/${pathOf(begun.experiment)}`;
    } catch (error) {
      answer.textContent = reason(error);
      button.disabled = false;
    }
    cancel.hidden = true;
  });
  choose();
  form.hidden = false;
}

/** @param {Offer[]} offers
 * @param {string} source
 * @param {string} label */
function groupOf(offers, source, label) {
  const options = offers.flatMap((offer, number) => (offer.source === source ? [new Option(offer.experiment, String(number))] : []));
  if (!options.length) return [];
  const group = Object.assign(document.createElement("optgroup"), { label });
  group.append(...options);
  return [group];
}
