// Where the object is to be put: a cross on the table, its long arm along the object's x axis.

import * as THREE from "three";
import { colour } from "./colours.js";
import { makeLabel } from "./label.js";
import { onTheme } from "./theme.js";

/** Half lengths of its arms and its height above the table, metres. */
const LONG = 0.1;
const SHORT = 0.05;
const HEIGHT = 0.0015;

/** Adds the cross for a goal (x, y, phi) to a scene. */
export function addGoal(stage, [x, y, phi]) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute([-LONG, 0, 0, LONG, 0, 0, 0, -SHORT, 0, 0, SHORT, 0], 3));
  const cross = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial());
  cross.position.set(x, y, HEIGHT);
  cross.rotation.z = phi;
  const label = makeLabel("goal");
  label.position.set(x, y + SHORT + 0.04, 0.015);
  stage.scene.add(cross, label);
  onTheme(() => {
    cross.material.color = colour("truth");
    label.userData.paint(colour("truth").getStyle());
  });
}
