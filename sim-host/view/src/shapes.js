// Geometry of the payload's solids.

import * as THREE from "three";
import { unpack } from "./unpack.js";

const MAKERS = {
  box: ({ size_m }) => new THREE.BoxGeometry(...size_m),
  sphere: ({ size_m }) => new THREE.SphereGeometry(0.5, 32, 20).scale(...size_m),
  cylinder: ({ size_m, bottom, top }) =>
    // three's cylinders stand along y.
    new THREE.CylinderGeometry(top / 2, bottom / 2, 1, 40).rotateX(Math.PI / 2).scale(...size_m),
  mesh: ({ vertices_m, triangles }) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(unpack(vertices_m), 3));
    if (triangles !== null) geometry.setIndex(new THREE.BufferAttribute(unpack(triangles), 1));
    const flat = geometry.index === null ? geometry : geometry.toNonIndexed();
    flat.computeVertexNormals();
    return flat;
  },
};

/** The geometry of a shape, already placed in its body's frame. */
export function geometryOf(shape) {
  const [x, y, z, ...q] = shape.pose;
  const place = new THREE.Matrix4().compose(
    new THREE.Vector3(x, y, z),
    new THREE.Quaternion(...q).normalize(),
    new THREE.Vector3(1, 1, 1),
  );
  return MAKERS[shape.kind](shape).applyMatrix4(place);
}
