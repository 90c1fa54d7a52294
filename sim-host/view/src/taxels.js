// The cells of the tactile pads on the hand, coloured by pressure.

import * as THREE from "three";

/** Lifted off the surface by this much, so that they are seen, metres; and their share of the cell. */
const LIFT = 0.0006;
const FILL = 0.9;

function placed(cell) {
  const normal = new THREE.Vector3(...cell.normal);
  const along = new THREE.Vector3(...cell.along);
  const across = new THREE.Vector3().crossVectors(normal, along);
  const turn = new THREE.Matrix4().makeBasis(along.multiplyScalar(FILL * cell.size_m[0]), across.multiplyScalar(FILL * cell.size_m[1]), normal);
  const [x, y, z] = cell.centre_m;
  return turn.setPosition(x + LIFT * cell.normal[0], y + LIFT * cell.normal[1], z + LIFT * cell.normal[2]);
}

/** The cells of all pads; `show(pad, pressures)` colours one pad. */
export function makeTaxels(pads, frames, colourMap) {
  const square = new THREE.PlaneGeometry(1, 1);
  const meshes = pads.map((pad) => {
    const cells = new THREE.InstancedMesh(square, new THREE.MeshBasicMaterial(), pad.cells.length);
    pad.cells.forEach((cell, i) => cells.setMatrixAt(i, placed(cell)));
    frames.all[pad.frame].add(cells);
    return cells;
  });
  return {
    show(i, pressures) {
      pressures.forEach((pressure, cell) => meshes[i].setColorAt(cell, colourMap.at(pressure)));
      meshes[i].instanceColor.needsUpdate = true;
    },
  };
}
