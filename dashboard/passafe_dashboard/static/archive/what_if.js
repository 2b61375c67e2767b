// Asks for a run to be made again with something changed.

import { element, reason } from "./page_parts.js";
import { startJob } from "./server.js";

/** Fields of the form for one link: the name in a scenario, and what a unit of the field is there. */
const LINK_FIELDS = [
  { field: "delay_ms", name: "delay_s", unit: 1e-3 },
  { field: "jitter_ms", name: "jitter_s", unit: 1e-3 },
  { field: "loss_percent", name: "loss", unit: 1e-2 },
];
export const LINKS = ["operator-to-filter", "filter-to-plant", "plant-to-filter", "plant-to-operator"];
const CHANGED = ["filter", "plant", "links"];

/** Returns the changes of a form as values of a scenario, by dotted name.
 * @param {{get: (name: string) => FormDataEntryValue | null | undefined}} form
 * @returns {Record<string, unknown>} */
export function changesOf(form) {
  /** @param {string} name */
  const typed = (name) => String(form.get(name) ?? "").trim();
  /** @type {Record<string, unknown>} */
  const changes = {};
  for (const { field, name, unit } of LINK_FIELDS) {
    if (!typed(field)) continue;
    if (!typed("link")) throw new Error("Which link is to be changed?");
    changes[`links.${typed("link")}.${name}`] = Number((Number(typed(field)) * unit).toPrecision(12));
  }
  for (const name of ["mode", "law"]) if (typed(name)) changes[`filter.${name}`] = typed(name);
  if (typed("value") && !typed("key")) throw new Error("Which key has this value?");
  if (typed("key")) changes[typed("key")] = valueOf(typed("value"));
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
  const form = /** @type {HTMLFormElement} */ (element("what-if-form"));
  const link = /** @type {HTMLSelectElement} */ (form.elements.namedItem("link"));
  link.append(...LINKS.map((name) => new Option(name, name)));
  const scenario = JSON.parse(document.querySelector("#report pre")?.textContent || "{}");
  element("keys").append(...numbersOf(scenario).map((key) => new Option(key, key)));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const answer = element("what-if-answer");
    answer.textContent = "";
    try {
      const asked = new FormData(form);
      const [operator, links] = [asked.get("operator"), asked.get("links")];
      const { job } = await startJob({ kind: "what-if", log, changes: changesOf(asked), operator, links });
      location.href = `/jobs/${job}`;
    } catch (error) {
      answer.textContent = reason(error);
    }
  });
  element("what-if").hidden = false;
}
