// The believed object: where its ghost is, the 99 % ellipse of its place on the table, the 99 % wedge of its yaw.

import * as THREE from "three";
import { colour } from "./colours.js";
import { onTheme } from "./theme.js";
import { before } from "./times.js";
import { unpack } from "./unpack.js";

/** 99 % of a normal distribution: in two dimensions within the root of this, in one within that many deviations. */
const CHI_SQUARED_2_99 = 9.21;
const NORMAL_99 = 2.576;
const POINTS = 72;
const HEIGHT = 0.002;

/** Half axes and direction of the 99 % ellipse of a covariance (xx, xy, yy). */
export function ellipse(xx, xy, yy) {
  const mean = (xx + yy) / 2;
  const off = Math.hypot((xx - yy) / 2, xy);
  const axis = (value) => Math.sqrt(CHI_SQUARED_2_99 * Math.max(0, value));
  return { a: axis(mean + off), b: axis(mean - off), turn: 0.5 * Math.atan2(2 * xy, xx - yy) };
}

function fan() {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * (POINTS + 2)), 3));
  const index = [];
  for (let i = 1; i <= POINTS; i += 1) index.push(0, i, i + 1);
  geometry.setIndex(index);
  return geometry;
}

function sheet(order, opacity) {
  const material = new THREE.MeshBasicMaterial({ transparent: true, opacity, depthTest: false, depthWrite: false, side: THREE.DoubleSide });
  const area = Object.assign(new THREE.Mesh(fan(), material), { renderOrder: order, frustumCulled: false });
  const rim = new THREE.BufferGeometry();
  rim.setAttribute("position", area.geometry.getAttribute("position"));
  const border = Object.assign(new THREE.Line(rim, new THREE.LineBasicMaterial({ depthTest: false, transparent: true })), { renderOrder: order + 1, frustumCulled: false });
  return { area, border };
}

/** The belief at any moment: `group` carries the ghost; `at(t)` moves all and returns the numbers, or null if none hold. */
export function makeBelief(stage, belief) {
  const times = unpack(belief.times_s);
  const poses = unpack(belief.poses);
  const covariances = unpack(belief.covariances);
  const group = new THREE.Group();
  const place = sheet(4, 0.3);
  const yaw = sheet(6, 0.25);
  const all = [group, place.area, place.border, yaw.area, yaw.border];
  stage.scene.add(...all);

  function draw({ area }, centre, point) {
    const positions = area.geometry.getAttribute("position");
    positions.setXYZ(0, centre[0], centre[1], HEIGHT);
    for (let i = 0; i <= POINTS; i += 1) positions.setXYZ(i + 1, ...point(i / POINTS), HEIGHT);
    positions.needsUpdate = true;
  }

  function show(now) {
    const { a, b, turn } = ellipse(now.covariance[0], now.covariance[1], now.covariance[3]);
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    draw(place, [now.x, now.y], (share) => {
      const [u, v] = [a * Math.cos(2 * Math.PI * share), b * Math.sin(2 * Math.PI * share)];
      return [now.x + c * u - s * v, now.y + s * u + c * v];
    });
    const half = Math.min(Math.PI, NORMAL_99 * Math.sqrt(Math.max(0, now.covariance[5])));
    draw(yaw, [now.x, now.y], (share) => {
      const angle = now.phi + half * (2 * share - 1);
      return [now.x + belief.radius_m * Math.cos(angle), now.y + belief.radius_m * Math.sin(angle)];
    });
  }

  onTheme(() => {
    for (const part of [place, yaw]) {
      part.area.material.color = colour("belief");
      part.border.material.color = colour("belief");
    }
  });

  return {
    group,
    at(t) {
      const i = before(times, t);
      const [x, y, z, phi] = i < 0 ? [NaN] : poses.subarray(4 * i, 4 * i + 4);
      all.forEach((part) => (part.visible = Number.isFinite(x)));
      if (!Number.isFinite(x)) return null;
      const now = { x, y, z, phi, covariance: covariances.subarray(6 * i, 6 * i + 6) };
      group.position.set(x, y, z);
      group.rotation.set(0, 0, phi);
      show(now);
      return now;
    },
  };
}
