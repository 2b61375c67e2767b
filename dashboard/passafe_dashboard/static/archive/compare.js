// The page of two runs over one another.

import { showReport, showTrouble, watchJob } from "./job_view.js";
import { element, reason } from "./page_parts.js";
import { startJob } from "./server.js";

const asked = new URLSearchParams(location.search);
const logs = asked.getAll("log");
const align = asked.get("align") ?? "start";

const select = /** @type {HTMLSelectElement} */ (document.querySelector("[name=align]"));
if (![...select.options].some((option) => option.value === align)) select.add(new Option(align, align));
select.value = align;
select.addEventListener("change", () => {
  asked.set("align", select.value);
  location.search = asked.toString();
});
element("name").textContent = logs.join(" and ");

async function open() {
  const done = await watchJob(await startJob({ kind: "compare", logs, align }));
  if (done) await showReport(done);
}

open().catch((error) => showTrouble(reason(error)));
