// The time line: phases, what happened, and the cursor.

import { ticks } from "./number.js";
import { svg } from "./svg.js";

const BAND = { top: 16, height: 20 };
const MARKS_Y = 8;
const AXIS_Y = 52;

/** Phases that belong together look alike. */
const LOOKS = { Initialise: 0, Plan: 0, Trial: 1, Update: 2, Grasp: 3, Transport: 3, Release: 3, Done: 4, Failed: 5, Fault: 5 };

const SIGNS = {
  touch: (x) => svg("path", { d: `M${x - 4} ${MARKS_Y - 4}h8l-4 8z` }),
  contact: (x) => svg("circle", { cx: x, cy: MARKS_Y, r: 3 }),
  update: (x) => svg("path", { d: `M${x - 5} ${MARKS_Y}l5 -5l5 5l-5 5z` }),
  other: (x) => svg("path", { d: `M${x} ${MARKS_Y - 4}v8` }),
};

function phaseParts(phase, x) {
  const [from, to] = [x(phase.from_s), x(phase.to_s)];
  const band = svg("rect", { class: `phase p${LOOKS[phase.name] ?? 0}`, x: from, y: BAND.top, width: Math.max(0.5, to - from), height: BAND.height });
  band.append(svg("title", {}, `${phase.name}, ${phase.from_s.toFixed(2)} s to ${phase.to_s.toFixed(2)} s`));
  if (to - from < 7 * phase.name.length + 4) return [band];
  return [band, svg("text", { class: "phase-name", x: (from + to) / 2, y: BAND.top + 14, "text-anchor": "middle", "pointer-events": "none" }, phase.name)];
}

function markParts(mark, x) {
  const sign = SIGNS[mark.kind](x(mark.at_s));
  sign.setAttribute("class", `mark ${mark.kind}`);
  sign.append(svg("title", {}, `${mark.at_s.toFixed(2)} s: ${mark.text}`));
  return sign;
}

/** The time line in `place`; `at(player)` moves its cursor. */
export function makeTimeline(place, { phases, marks }, player) {
  const cursor = svg("line", { class: "cursor", y1: 3, y2: AXIS_Y - 8 });
  const knob = svg("circle", { class: "knob", cy: AXIS_Y - 8, r: 5 });
  const drawing = svg("svg", { "aria-hidden": "true" });
  place.append(drawing);
  place.setAttribute("aria-valuemax", player.duration.toFixed(2));
  let x = null;

  function drawAll() {
    const width = place.clientWidth;
    x = (t) => 6 + (t / player.duration) * (width - 12);
    const { values, decimals } = ticks(0, player.duration, width / 90);
    const numbers = values.map((t) => svg("text", { x: x(t), y: AXIS_Y + 8, "text-anchor": t === 0 ? "start" : "middle" }, `${t.toFixed(decimals)} s`));
    const small = ticks(0, player.duration, width / 18).values.map((t) => `M${x(t).toFixed(1)} ${BAND.top + BAND.height}v4`);
    drawing.replaceChildren(
      ...phases.flatMap((phase) => phaseParts(phase, x)),
      svg("path", { class: "frame", d: small.join("") }),
      ...numbers,
      ...marks.map((mark) => markParts(mark, x)),
      cursor,
      knob,
    );
    at(player);
  }

  function at({ t }) {
    if (x === null) return;
    cursor.setAttribute("x1", x(t));
    cursor.setAttribute("x2", x(t));
    knob.setAttribute("cx", x(t));
    const phase = phases.findLast((p) => p.from_s <= t);
    place.setAttribute("aria-valuenow", t.toFixed(2));
    place.setAttribute("aria-valuetext", `${t.toFixed(2)} seconds${phase ? `, ${phase.name}` : ""}`);
  }

  const seek = (event) => {
    const { left, width } = place.getBoundingClientRect();
    player.seek(((event.clientX - left - 6) / (width - 12)) * player.duration);
  };
  place.addEventListener("pointerdown", (event) => {
    place.setPointerCapture(event.pointerId);
    seek(event);
  });
  place.addEventListener("pointermove", (event) => event.buttons === 1 && seek(event));
  new ResizeObserver(drawAll).observe(place);
  return { at };
}
