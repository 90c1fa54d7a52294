// Contact forces on the hand, as arrows that end where they attack.

import * as THREE from "three";
import { colour } from "./colours.js";
import { onTheme } from "./theme.js";
import { before } from "./times.js";
import { unpack } from "./unpack.js";

/** Lengths of an arrow's head, and between which it may be as a whole, metres. */
const HEAD = 0.02;
const SHORTEST = 0.03;
const LONGEST = 0.25;

/** Arrows for the contacts of any moment. */
export function makeForces(stage, contacts) {
  const times = unpack(contacts.times_s);
  const starts = unpack(contacts.starts);
  const points = unpack(contacts.points_m);
  const forces = unpack(contacts.arrows_m);
  const most = starts.reduce((most, start, i) => Math.max(most, (starts[i + 1] ?? start) - start), 0);
  const shaft = new THREE.CylinderGeometry(0.003, 0.003, 1, 10).translate(0, -0.5, 0);
  const head = new THREE.ConeGeometry(0.0085, HEAD, 16).translate(0, -HEAD / 2, 0);
  const material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true });
  const arrows = Array.from({ length: most }, () => {
    const arrow = new THREE.Group();
    const parts = [new THREE.Mesh(shaft, material), new THREE.Mesh(head, material)];
    parts.forEach((part) => (part.renderOrder = 8));
    arrow.add(...parts);
    stage.scene.add(arrow);
    return arrow;
  });
  const up = new THREE.Vector3(0, 1, 0);
  const force = new THREE.Vector3();

  onTheme(() => {
    material.color = colour("force");
  });

  return {
    at(t) {
      const i = before(times, t);
      const first = i < 0 ? 0 : starts[i];
      const count = i < 0 ? 0 : starts[i + 1] - first;
      arrows.forEach((arrow, k) => {
        arrow.visible = k < count;
        if (!arrow.visible) return;
        const at = 3 * (first + k);
        force.fromArray(forces, at);
        const length = Math.min(LONGEST, Math.max(SHORTEST, force.length()));
        arrow.position.fromArray(points, at);
        arrow.quaternion.setFromUnitVectors(up, force.normalize());
        arrow.children[0].position.y = -HEAD;
        arrow.children[0].scale.y = length - HEAD;
      });
    },
  };
}
