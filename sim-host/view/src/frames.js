// Poses of all frames at any moment.

import * as THREE from "three";
import { around } from "./times.js";
import { unpack } from "./unpack.js";

/** Reads the payload's frames; `at(t)` moves the groups `all[i]` to where they are then. */
export function makeFrames(frames) {
  const times = unpack(frames.times_s);
  const tracks = frames.poses.map(unpack);
  const all = frames.names.map((name) => Object.assign(new THREE.Group(), { name }));
  const later = new THREE.Quaternion();

  function place(group, track, { a, b, share }) {
    const i = track.length > 7 ? 7 * a : 0;
    const j = track.length > 7 ? 7 * b : 0;
    const mix = (k) => track[i + k] + share * (track[j + k] - track[i + k]);
    group.position.set(mix(0), mix(1), mix(2));
    group.quaternion.set(track[i + 3], track[i + 4], track[i + 5], track[i + 6]).normalize();
    later.set(track[j + 3], track[j + 4], track[j + 5], track[j + 6]).normalize();
    group.quaternion.slerp(later, share);
  }

  return {
    all,
    at(t) {
      const moment = around(times, t);
      all.forEach((group, i) => place(group, tracks[i], moment));
    },
  };
}
