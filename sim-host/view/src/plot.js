// Curves over time with axes, a cursor, and the values under it.

import { makeAxis } from "./axis.js";
import { decimalsFor, number, ticks } from "./number.js";
import { html, svg } from "./svg.js";
import { before } from "./times.js";
import { unpack } from "./unpack.js";

/** Room for the numbers of the axes, pixels. */
const LEFT = 36;
const BOTTOM = 13;
const TOP = 7;
const RIGHT = 2;

/** Where samples are farther apart than this, nothing was measured between them, seconds. */
const GAP = 0.5;

/** The samples that a curve is drawn through: of those in one column of pixels the least and the greatest. */
function seen(times, values, x) {
  const kept = [];
  for (let i = 0; i < times.length; ) {
    const column = Math.floor(x(times[i]));
    let [least, greatest] = [i, i];
    for (; i < times.length && Math.floor(x(times[i])) === column; i += 1) {
      if (values[i] < values[least]) least = i;
      if (values[i] > values[greatest]) greatest = i;
    }
    kept.push(Math.min(least, greatest));
    if (least !== greatest) kept.push(Math.max(least, greatest));
  }
  return kept;
}

function path(times, values, x, y) {
  let d = "";
  let last = -Infinity;
  for (const i of seen(times, values, x)) {
    d += `${times[i] - last < GAP ? "L" : "M"}${x(times[i]).toFixed(1)} ${y(values[i]).toFixed(1)}`;
    last = times[i];
  }
  return d;
}

function drawAll(drawing, plot, width, height, duration) {
  const x = (t) => LEFT + (t / duration) * (width - LEFT - RIGHT);
  const y = (v) => TOP + (1 - plot.axis.share(v)) * (height - TOP - BOTTOM);
  drawing.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const time = ticks(0, duration, Math.max(2, width / 80));
  const grid = [
    ...plot.axis.ticks.map((tick) => `M${LEFT} ${y(tick.value).toFixed(1)}H${width - RIGHT}`),
    ...time.values.map((t) => `M${x(t).toFixed(1)} ${TOP}V${height - BOTTOM}`),
  ];
  const parts = [svg("path", { class: "grid", d: grid.join("") })];
  for (const tick of plot.axis.ticks) parts.push(svg("text", { x: LEFT - 4, y: y(tick.value) + 3.5, "text-anchor": "end" }, tick.text));
  for (const t of time.values.filter((t) => x(t) < width - RIGHT - 16)) parts.push(svg("text", { x: x(t), y: height - 2, "text-anchor": "middle" }, t.toFixed(time.decimals)));
  parts.push(svg("text", { x: width - RIGHT, y: height - 2, "text-anchor": "end" }, "s"));
  plot.lines.forEach((line, i) => parts.push(svg("path", { class: `curve k${i % 8} d${i % 4}`, d: path(plot.times, line, x, y) })));
  parts.push(svg("rect", { class: "frame", x: LEFT, y: TOP, width: width - LEFT - RIGHT, height: height - TOP - BOTTOM }));
  drawing.replaceChildren(...parts, plot.cursor);
  plot.x = x;
}

/** A plot in `place`; `at(t)` moves its cursor. */
export function makePlot(place, source, player) {
  const lines = source.lines.map((line) => unpack(line.values));
  const plot = { times: unpack(source.times_s), lines, axis: makeAxis(source.scale, lines), cursor: svg("line", { class: "cursor" }), x: null };
  const drawing = svg("svg", { role: "img", "aria-label": `${source.title} over time, ${source.unit}` });
  const values = source.lines.map(() => html("output"));
  const keys = source.lines.map((line, i) => html("span", {}, html("i", { class: `k${i % 8}` }), line.name, values[i]));
  const area = html("div", { class: "plot" }, drawing);
  const single = source.lines.length === 1;
  const unit = `${source.unit} `;
  const caption = single ? [html("b", {}, source.title), html("span", {}, values[0], unit)] : [html("b", {}, `${source.title}, ${unit}`), ...keys];
  place.append(html("figure", { class: single ? "half" : lines.length > 4 ? "dense" : "" }, html("figcaption", {}, ...caption), area));

  // Values that span decades have each their own digits.
  const greatest = lines.reduce((most, line) => line.reduce((m, v) => Math.max(m, Math.abs(v)), most), 0);
  const shown = (v) => number(v, decimalsFor(source.scale === "log" ? v : greatest));

  function at({ t }) {
    if (plot.x === null) return;
    const x = plot.x(t).toFixed(1);
    const { height } = area.getBoundingClientRect();
    for (const [key, value] of [["x1", x], ["x2", x], ["y1", TOP], ["y2", height - BOTTOM]]) plot.cursor.setAttribute(key, value);
    const i = before(plot.times, t);
    values.forEach((element, k) => (element.textContent = i < 0 || t - plot.times[i] > GAP ? "–" : shown(plot.lines[k][i])));
  }

  new ResizeObserver(() => {
    const { width, height } = area.getBoundingClientRect();
    if (width < 80 || height < 30) return;
    drawAll(drawing, plot, width, height, player.duration);
    at(player);
  }).observe(area);
  const seek = (event) => {
    const { left, width } = area.getBoundingClientRect();
    player.seek(((event.clientX - left - LEFT) / (width - LEFT - RIGHT)) * player.duration);
  };
  area.addEventListener("pointerdown", (event) => {
    area.setPointerCapture(event.pointerId);
    seek(event);
  });
  area.addEventListener("pointermove", (event) => event.buttons === 1 && seek(event));
  return { at };
}
