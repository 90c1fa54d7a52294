// The value axis of a plot: its range, its ticks, and where a value is on it.

import { number, ticks } from "./number.js";

function linear(low, high) {
  const pad = high > low ? 0.05 * (high - low) : 1;
  const [from, to] = [low - pad, high + pad];
  const { values, decimals } = ticks(from, to, 3);
  return {
    share: (v) => (v - from) / (to - from),
    ticks: values.map((v) => ({ value: v, text: number(v, decimals) })),
  };
}

/** Decades; what is smaller than a ten-thousandth of the greatest is at the lower end. */
function logarithmic(low, high) {
  const top = high > 0 ? high : 1;
  const from = Math.floor(Math.log10(Math.max(low, top * 1e-4)));
  const to = Math.max(from + 1, Math.ceil(Math.log10(top)));
  const values = Array.from({ length: to - from + 1 }, (_, i) => 10 ** (from + i));
  return {
    share: (v) => Math.min(1, Math.max(0, (Math.log10(Math.max(v, 1e-30)) - from) / (to - from))),
    ticks: values.map((v) => ({ value: v, text: v >= 1 ? String(v) : v.toFixed(-Math.round(Math.log10(v))) })),
  };
}

/** An axis for these values. */
export function makeAxis(scale, lines) {
  let [low, high] = [Infinity, -Infinity];
  for (const line of lines) {
    for (const v of line) {
      if (v > high) high = v;
      if (v < low && (scale === "linear" || v > 0)) low = v;
    }
  }
  if (low > high) [low, high] = [0, 1];
  return scale === "log" ? logarithmic(low, high) : linear(low, high);
}
