// Asks for a run to be made again with something changed.

import { startJob } from "./server.js";

const LINK_FIELDS = { delay_ms: ["delay_s", 1e-3], jitter_ms: ["jitter_s", 1e-3], loss_percent: ["loss", 1e-2] };
export const LINKS = ["operator-to-filter", "filter-to-plant", "plant-to-filter", "plant-to-operator"];
const CHANGED = ["filter", "plant", "links"];

/** Returns the changes of a form as values of a scenario, by dotted name.
 * @param {FormData} form */
export function changesOf(form) {
  const changes = {};
  const link = form.get("link");
  for (const [field, [name, factor]] of Object.entries(LINK_FIELDS)) {
    const text = String(form.get(field) ?? "").trim();
    if (!text) continue;
    if (!link) throw new Error("Which link is to be changed?");
    changes[`links.${link}.${name}`] = Number(text) * factor;
  }
  for (const name of ["mode", "law"]) if (form.get(name)) changes[`filter.${name}`] = form.get(name);
  const key = String(form.get("key") ?? "").trim();
  if (key) changes[key] = valueOf(String(form.get("value") ?? "").trim());
  return changes;
}

/** Returns what a person typed as a number, truth or list where it is one.
 * @param {string} text */
function valueOf(text) {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}

/** Returns the dotted names of the numbers in a scenario that may be changed.
 * @param {any} value
 * @param {string} path
 * @returns {string[]} */
export function numbersOf(value, path = "") {
  if (typeof value === "number") return [path];
  if (value === null || typeof value !== "object") return [];
  return Object.entries(value)
    .filter(([key]) => path || CHANGED.includes(key))
    .flatMap(([key, inner]) => numbersOf(inner, path ? `${path}.${key}` : key));
}

/** Shows the form below the log's name.
 * @param {string} log */
export function offerWhatIf(log) {
  const box = /** @type {HTMLDetailsElement} */ (document.getElementById("what-if"));
  const form = /** @type {HTMLFormElement} */ (document.getElementById("what-if-form"));
  const answer = document.getElementById("what-if-answer");
  form.elements.namedItem("link").append(...LINKS.map((link) => new Option(link, link)));
  const scenario = JSON.parse(document.querySelector("#report pre")?.textContent || "{}");
  document.getElementById("keys").append(...numbersOf(scenario).map((key) => new Option(key, key)));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    answer.textContent = "";
    try {
      const asked = new FormData(form);
      const request = { kind: "what-if", log, changes: changesOf(asked), operator: asked.get("operator"), links: asked.get("links") };
      const { job } = await startJob(request);
      location.href = `/jobs/${job}`;
    } catch (error) {
      answer.textContent = error.message;
    }
  });
  box.hidden = false;
}
