// What the tactile pads read at any moment, shown on the hand and in the panel.

import { before } from "./times.js";
import { unpack } from "./unpack.js";

/** Readings of all pads, shown by `views`. */
export function makePads(pads, views) {
  const readings = pads.map((pad) => ({
    times: unpack(pad.times_s),
    pressures: unpack(pad.pressures_n_cm2),
    none: new Float32Array(pad.cells.length),
    shown: undefined,
  }));
  return {
    at(t) {
      readings.forEach((pad, i) => {
        const at = before(pad.times, t);
        if (at === pad.shown) return;
        pad.shown = at;
        const count = pad.none.length;
        const now = at < 0 ? pad.none : pad.pressures.subarray(at * count, (at + 1) * count);
        views.forEach((view) => view.show(i, now));
      });
    },
  };
}
