// Words in the 3D view.

import * as THREE from "three";

const HEIGHT_PX = 48;
/** Height of a label as a share of its distance: about as large as the page's small print. */
const SHARE = 0.017;

/** A sprite with a text, as large from near as from far; `userData.paint(colour)` writes it. */
export function makeLabel(text) {
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d");
  const font = `${HEIGHT_PX * 0.75}px system-ui, sans-serif`;
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 8;
  canvas.height = HEIGHT_PX;
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, depthWrite: false, sizeAttenuation: false }));
  sprite.scale.set((SHARE * canvas.width) / HEIGHT_PX, SHARE, 1);
  sprite.userData.paint = (colour) => {
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.font = font;
    pen.fillStyle = colour;
    pen.textBaseline = "middle";
    pen.fillText(text, 4, HEIGHT_PX / 2);
    texture.needsUpdate = true;
  };
  return sprite;
}
