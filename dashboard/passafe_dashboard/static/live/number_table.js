// Numbers and rows of the engineers' tables.

import { numberText } from "../report/number_text.js";
import { setText } from "./elements.js";

const NOTHING = 1e-9;

/** Returns a number as people read it; what is smaller than any reader cares for is 0.
 * @param {number | null | undefined} value
 * @param {number} [digits] */
export function number(value, digits = 4) {
  if (value === null || value === undefined) return "–";
  return Math.abs(value) < NOTHING ? "0" : numberText(value, digits);
}

/** @param {number[] | null | undefined} values */
export const vector = (values) => (values?.length ? `(${values.map((value) => number(value)).join(", ")})` : "–");

/** @param {number | null | undefined} value */
export const seconds = (value) => (value === null || value === undefined ? "–" : `${value.toFixed(2)}\u00a0s`);

/** @param {number} share */
export const percent = (share) => `${Math.round(100 * share)} %`.replace("-", "−");

/** Makes a table body have these rows of text; cells are reused, so nothing flickers and selection stays.
 * @param {HTMLElement} place
 * @param {string[][]} rows
 * @param {(row: HTMLTableRowElement, index: number) => void} [decorate] */
export function fill(place, rows, decorate) {
  const body = /** @type {HTMLTableSectionElement} */ (place);
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach((cells, r) => {
    const row = body.rows[r] ?? body.insertRow();
    cells.forEach((text, c) => {
      let cell = row.cells[c];
      if (!cell) {
        cell = document.createElement(c === 0 ? "th" : "td");
        if (c === 0) cell.scope = "row";
        row.append(cell);
      }
      setText(cell, text);
    });
    decorate?.(row, r);
  });
}
