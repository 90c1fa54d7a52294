// Where a moment lies among sampled times.

/** Index of the last sample at or before `t`; -1 before the first. */
export function before(times, t) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The two samples around `t` and the share of the later one. */
export function around(times, t) {
  const last = times.length - 1;
  const a = Math.max(0, before(times, t));
  const b = Math.min(a + 1, last);
  const span = times[b] - times[a];
  return { a, b, share: span > 0 ? Math.min(1, Math.max(0, (t - times[a]) / span)) : 0 };
}
