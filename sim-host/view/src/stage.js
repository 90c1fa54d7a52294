// The 3D view: renderer, light, camera, and when to draw.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { colour } from "./colours.js";
import { onTheme } from "./theme.js";

/** Standard views: where the camera is and what it looks at, metres in the frame of the robot's base. */
const VIEWS = {
  all: { from: [1.9, -1.3, 1.02], at: [0.43, -0.07, 0.22] },
  top: { from: [0.46, 0, 2.35], at: [0.46, 0, 0] },
};
/** The camera beside the hand, from the middle between its fingertips. */
const BESIDE_HAND = new THREE.Vector3(0.52, 0.5, 0.3);
/** From the hand's frame to between its fingertips, metres. */
const GRASP_POINT = new THREE.Vector3(0, 0, 0.16);

/** A stage on a canvas; views are from `base`, and `hand` is the frame that the camera can follow. */
export function makeStage(canvas, base, hand) {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  renderer.shadowMap.enabled = true;
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(32, 1, 0.02, 20);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  controls.minDistance = 0.1;
  controls.maxDistance = 6;
  light(scene);

  const aim = new THREE.Vector3();
  const aimed = new THREE.Vector3();
  const shift = new THREE.Vector3();
  let follows = false;
  let due = false;

  function target(into) {
    return hand.localToWorld(into.copy(GRASP_POINT));
  }

  function resize() {
    const { clientWidth, clientHeight } = canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(clientWidth, clientHeight, false);
    camera.aspect = clientWidth / clientHeight;
    camera.updateProjectionMatrix();
    draw();
  }

  /** Draws once, soon. */
  function draw() {
    if (due) return;
    due = true;
    requestAnimationFrame(() => {
      due = false;
      renderer.render(scene, camera);
    });
  }

  /** Moves the camera as far as the hand went since. */
  function follow() {
    target(aim);
    if (follows) {
      shift.subVectors(aim, aimed);
      camera.position.add(shift);
      controls.target.add(shift);
      controls.update();
    }
    aimed.copy(aim);
  }

  function look(name) {
    if (name === "hand") {
      target(controls.target);
      camera.position.copy(controls.target).add(BESIDE_HAND);
    } else {
      base.localToWorld(camera.position.set(...VIEWS[name].from));
      base.localToWorld(controls.target.set(...VIEWS[name].at));
    }
    controls.update();
    draw();
  }

  /** Turns the camera about its target, radians, and moves it nearer by a factor. */
  function turn(azimuth, elevation, factor) {
    const offset = camera.position.clone().sub(controls.target);
    // Spherical coordinates about z.
    const sphere = new THREE.Spherical().setFromCartesianCoords(offset.y, offset.z, offset.x);
    sphere.theta += azimuth;
    sphere.phi -= elevation;
    sphere.radius *= factor;
    sphere.makeSafe();
    const to = new THREE.Vector3().setFromSpherical(sphere);
    camera.position.set(to.z, to.x, to.y).add(controls.target);
    controls.update();
    draw();
  }

  function setFollow(on) {
    follows = on;
    target(aimed);
  }

  controls.addEventListener("change", draw);
  new ResizeObserver(resize).observe(canvas);
  onTheme(() => {
    scene.background = colour("paper");
    draw();
  });
  return { scene, camera, draw, follow, look, turn, setFollow };
}

function light(scene) {
  scene.add(new THREE.HemisphereLight(0xffffff, 0xb0aca4, 2.0));
  const sun = new THREE.DirectionalLight(0xffffff, 1.7);
  sun.position.set(0.9, 0.7, 2.4);
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  Object.assign(sun.shadow.camera, { left: -1.3, right: 1.3, top: 1.3, bottom: -1.3, near: 0.5, far: 5 });
  sun.shadow.normalBias = 0.01;
  scene.add(sun);
}
