// Numbers as people read them.

const MINUS = "−";
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** @param {number} exponent */
function power(exponent) {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPTS[Number(digit)]).join("");
  return `10${exponent < 0 ? "⁻" : ""}${digits}`;
}

/** Returns a number with `digits` digits that count; 0 for what is smaller than anything a reader cares for.
 * @param {number} value
 * @param {number} digits */
export function numberText(value, digits = 3) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "–" : value > 0 ? "∞" : `${MINUS}∞`;
  const size = Math.abs(value);
  if (size === 0) return "0";
  const exponent = Math.floor(Math.log10(size));
  if (exponent >= 5 || exponent < -4) {
    const factor = (value / 10 ** exponent).toFixed(Math.max(digits - 2, 0));
    return `${factor.replace("-", MINUS)}·${power(exponent)}`;
  }
  return value.toFixed(Math.max(digits - 1 - exponent, 0)).replace("-", MINUS);
}

/** Returns lowest and highest value as one text.
 * @param {[number, number] | null} range */
export function rangeText(range) {
  if (!range) return "–";
  const [low, high] = range.map((value) => numberText(value));
  return low === high ? low : `${low} … ${high}`;
}

/** Returns a time with as many places as a step between times needs.
 * @param {number} seconds
 * @param {number} step */
export function timeText(seconds, step = 0.001) {
  const places = Math.min(Math.max(Math.ceil(-Math.log10(step) - 1e-9), 0), 6);
  return seconds.toFixed(places).replace("-", MINUS);
}
