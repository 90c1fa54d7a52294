// A small picture of each pad, and its greatest pressure.

import { number } from "./number.js";
import { html, svg } from "./svg.js";

function picture(pad) {
  const places = pad.cells.map((cell) => cell.place);
  const width = Math.max(...places.map((p) => p[0])) + 1;
  const height = Math.max(...places.map((p) => p[1])) + 1;
  const drawing = svg("svg", { viewBox: `-0.1 -0.1 ${width + 0.2} ${height + 0.2}`, role: "img", "aria-label": `Pressures of ${pad.name}` });
  const cells = places.map(([x, y]) => svg("rect", { x, y, width: 1, height: 1 }));
  drawing.append(...cells);
  return { drawing, cells };
}

/** Pictures of the pads in `place`; `show(pad, pressures)` colours one. */
export function makePadPanel(place, pads, colourMap) {
  const panels = pads.map((pad) => {
    const { drawing, cells } = picture(pad);
    const most = html("b");
    place.append(html("figure", {}, html("figcaption", {}, `${pad.name} `, most), drawing));
    return { cells, most };
  });
  return {
    show(i, pressures) {
      const { cells, most } = panels[i];
      pressures.forEach((pressure, cell) => {
        cells[cell].style.fill = colourMap.style(pressure);
      });
      most.textContent = `${number(Math.max(...pressures), 1)} N/cm²`;
    },
  };
}
