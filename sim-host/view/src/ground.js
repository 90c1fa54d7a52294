// The floor's grid in metres, and the axes of the world.

import * as THREE from "three";
import { colour } from "./colours.js";
import { makeLabel } from "./label.js";
import { number } from "./number.js";
import { onTheme } from "./theme.js";

/** The grid's range, in tenths of a metre. */
const X = [-12, 12];
const Y = [-10, 6];
/** Just above the table's top, so that the lines are seen on it. */
const HEIGHT = 0.0008;
/** Where the grid's numbers stand: x of those along y, y of those along x. */
const EDGE = [-1.0, 0.37];
/** Numbers stand this much above the grid, so that it does not cut them. */
const LIFT = 0.015;
/** Where the triad stands, and how long its axes are. */
const CORNER = [-0.76, -0.2, 0.02];
const AXIS = 0.16;

function lines(points) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ transparent: true }));
}

function grid() {
  const fine = [];
  const bold = [];
  const across = (at, put) => (at % 5 === 0 ? bold : fine).push(...put);
  for (let i = X[0]; i <= X[1]; i += 1) across(i, [i / 10, Y[0] / 10, HEIGHT, i / 10, Y[1] / 10, HEIGHT]);
  for (let i = Y[0]; i <= Y[1]; i += 1) across(i, [X[0] / 10, i / 10, HEIGHT, X[1] / 10, i / 10, HEIGHT]);
  return [lines(fine), lines(bold)];
}

function metres(tenths) {
  return `${number(tenths / 10, 1)} m`;
}

/** Adds grid, its numbers and the triad to a scene. */
export function addGround(stage) {
  const [fine, bold] = grid();
  stage.scene.add(fine, bold);
  const labels = [];
  const label = (text, x, y, z) => {
    const sprite = makeLabel(text);
    sprite.position.set(x, y, z);
    labels.push(sprite);
    stage.scene.add(sprite);
  };
  for (let i = -5; i <= 5; i += 5) label(`x ${metres(i)}`, i / 10, EDGE[1], LIFT);
  for (let i = -5; i <= 0; i += 5) label(`y ${metres(i)}`, EDGE[0], i / 10, LIFT);

  const triad = ["c8", "c2", "c0"].map((name, i) => {
    const direction = new THREE.Vector3().setComponent(i, 1);
    const arrow = new THREE.ArrowHelper(direction, new THREE.Vector3(...CORNER), AXIS, 0xffffff, 0.045, 0.026);
    stage.scene.add(arrow);
    const tip = direction.multiplyScalar(AXIS + 0.05).add(new THREE.Vector3(...CORNER));
    label("xyz"[i], tip.x, tip.y, tip.z);
    return { arrow, name };
  });

  onTheme(() => {
    fine.material.color = colour("soft");
    fine.material.opacity = 0.22;
    bold.material.color = colour("soft");
    bold.material.opacity = 0.6;
    labels.forEach((sprite) => sprite.userData.paint(colour("soft").getStyle()));
    triad.forEach(({ arrow, name }) => arrow.setColor(colour(name)));
    stage.draw();
  });
}
