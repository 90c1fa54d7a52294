// Numbers as people read them.

/** With this many decimals and a true minus sign. */
export function number(value, decimals) {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** The same with a plus sign where it is not negative. */
export function signed(value, decimals) {
  const text = number(value, decimals);
  return text.startsWith("−") ? text : `+${text}`;
}

/** Decimals that suit values up to this size: three digits. */
export function decimalsFor(size) {
  return size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
}

/** About `count` round numbers from `low` to `high`. */
export function ticks(low, high, count) {
  const rough = (high - low) / count;
  const decade = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * decade).find((s) => s >= rough * 0.999);
  const values = [];
  for (let i = Math.ceil(low / step - 1e-6); i * step <= high + 1e-6 * step; i += 1) values.push(i * step);
  return { values, decimals: Math.max(0, -Math.floor(Math.log10(step * 1.0001))) };
}
