// The present moment of the replay, and its speed.

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];

/** A clock over [0, duration]; listeners are called with it at every change. */
export function makePlayer(duration, marks) {
  const listeners = [];
  let stamp = null;

  const player = {
    t: 0,
    duration,
    speed: 1,
    playing: false,
    on(listener) {
      listeners.push(listener);
    },
    seek(t) {
      player.t = Math.min(duration, Math.max(0, t));
      tell();
    },
    step(dt) {
      player.seek(player.t + dt);
    },
    toMark(direction) {
      const ahead = marks.filter((mark) => (direction > 0 ? mark.at_s > player.t + 1e-3 : mark.at_s < player.t - 1e-3));
      const mark = direction > 0 ? ahead[0] : ahead[ahead.length - 1];
      player.seek(mark ? mark.at_s : direction > 0 ? duration : 0);
    },
    setSpeed(speed) {
      player.speed = speed;
      tell();
    },
    faster(direction) {
      const at = SPEEDS.indexOf(player.speed) + direction;
      player.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at))]);
    },
    toggle() {
      player.playing = !player.playing;
      if (player.playing && player.t >= duration) player.t = 0;
      stamp = null;
      if (player.playing) requestAnimationFrame(advance);
      tell();
    },
  };

  function advance(now) {
    if (!player.playing) return;
    player.t += stamp === null ? 0 : (player.speed * (now - stamp)) / 1000;
    stamp = now;
    if (player.t >= duration) {
      player.t = duration;
      player.playing = false;
    } else {
      requestAnimationFrame(advance);
    }
    tell();
  }

  function tell() {
    listeners.forEach((listener) => listener(player));
  }

  return player;
}
