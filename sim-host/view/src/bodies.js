// The bodies of a run: solid where they are real, a ghost where they are believed to be.

import * as THREE from "three";
import { colour } from "./colours.js";
import { geometryOf } from "./shapes.js";
import { onTheme } from "./theme.js";

/** How each role is drawn: colour of the style sheet, and how much paper is mixed into it. */
const LOOKS = {
  arm: { name: "soft", paper: 0.55 },
  hand: { name: "soft", paper: 0.25 },
  table: { name: "panel", paper: 0 },
  truth: { name: "truth", paper: 0.15 },
  obstacle: { name: "c5", paper: 0.35 },
  loose: { name: "c9", paper: 0.35 },
  belief: { name: "belief", paper: 0 },
};
/** Edges where faces meet at more than this angle are drawn, degrees. */
const CREASE_DEG = 32;

function solid(role) {
  const material = new THREE.MeshLambertMaterial();
  const edges = new THREE.LineBasicMaterial({ transparent: true, opacity: role === "arm" || role === "hand" ? 0.35 : 0.7 });
  return { material, edges };
}

function ghost() {
  const material = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.2, depthWrite: false });
  const edges = new THREE.LineDashedMaterial({ dashSize: 0.012, gapSize: 0.007, depthTest: false });
  return { material, edges };
}

function mesh(geometry, { material, edges }, isGhost) {
  const body = new THREE.Mesh(geometry, material);
  body.castShadow = !isGhost;
  body.receiveShadow = !isGhost;
  const outline = new THREE.LineSegments(new THREE.EdgesGeometry(geometry, CREASE_DEG), edges);
  if (isGhost) {
    outline.computeLineDistances();
    body.renderOrder = 2;
    outline.renderOrder = 3;
  }
  return [body, outline];
}

/** Adds all bodies to their frames; `places.belief` carries what is only believed. */
export function addBodies(stage, bodies, frames, places) {
  const materials = [];
  for (const body of bodies) {
    const isGhost = body.role === "belief";
    const look = isGhost ? ghost() : solid(body.role);
    const parent = isGhost ? places.belief : body.frame === null ? stage.scene : frames.all[body.frame];
    for (const shape of body.shapes) parent.add(...mesh(geometryOf(shape), look, isGhost));
    materials.push({ ...LOOKS[body.role], ...look, isGhost });
  }
  onTheme(() => {
    for (const { name, paper, material, edges, isGhost } of materials) {
      material.color = colour(name).lerp(colour("paper"), paper);
      edges.color = isGhost ? colour(name) : colour("ink");
    }
    stage.draw();
  });
}
