// The numbers of the present moment: phase, belief, truth, difference.

import * as THREE from "three";
import { number, signed } from "./number.js";
import { html } from "./svg.js";

const DEG = 180 / Math.PI;

function pose(x, y, phi) {
  const column = (text, width) => text.padStart(width, "\u2007");
  return `${column(signed(1000 * x, 1), 6)}, ${column(signed(1000 * y, 1), 6)} mm  ${column(signed(DEG * phi, 2), 7)}°`;
}

/** The yaw of a frame: direction of its x axis on the table. */
function yawOf(group) {
  const x = new THREE.Vector3(1, 0, 0).applyQuaternion(group.quaternion);
  return Math.atan2(x.y, x.x);
}

/** Numbers in `place`; `at(t, belief)` brings them up to date. */
export function makeReadout(place, phases, truth) {
  const rows = ["phase", "truth", "belief", "99 %"].map((name) => {
    const value = html("dd");
    place.append(html("dt", {}, name), value);
    return value;
  });
  return {
    at(t, belief) {
      rows[0].textContent = phases.findLast((phase) => phase.from_s <= t)?.name ?? "–";
      rows[1].textContent = truth ? pose(truth.position.x, truth.position.y, yawOf(truth)) : "–";
      rows[2].textContent = belief ? pose(belief.x, belief.y, belief.phi) : "–";
      rows[3].textContent = belief ? spread(belief.covariance) : "–";
    },
  };
}

function spread(covariance) {
  const half = (i, unit) => number(2.576 * unit * Math.sqrt(Math.max(0, covariance[i])), 2);
  return `±${half(0, 1000)}, ±${half(3, 1000)} mm  ±${half(5, DEG)}°`;
}
