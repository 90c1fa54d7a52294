// The page's colours: of the style sheet, and of pressures.

import * as THREE from "three";

const probe = document.createElement("span");
probe.hidden = true;
document.body.append(probe);

/** The present colour of a custom property of the style sheet. */
export function colour(name) {
  probe.style.color = `var(--${name})`;
  return new THREE.Color().setStyle(getComputedStyle(probe).color);
}

/** Colours of pressures from none to `most`; by their square roots, so that light touches are seen beside a grasp. */
export function makeColourMap(points, most) {
  const colours = points.map((p) => new THREE.Color(p));
  const mixed = new THREE.Color();
  const at = (pressure) => {
    const place = Math.sqrt(Math.min(1, Math.max(0, pressure / most))) * (colours.length - 1);
    const i = Math.min(Math.floor(place), colours.length - 2);
    return mixed.lerpColors(colours[i], colours[i + 1], place - i);
  };
  return {
    at,
    style: (pressure) => at(pressure).getStyle(),
    gradient: `linear-gradient(to right, ${points.join(", ")})`,
  };
}
