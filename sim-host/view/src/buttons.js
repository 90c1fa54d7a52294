// The buttons, and what they show.

import { toggleTheme } from "./theme.js";

const get = (id) => document.getElementById(id);

/** Makes the buttons work; returns what keys do too. */
export function connect(player, stage, marks) {
  const actions = {
    theme: toggleTheme,
    help: () => get("keys").showModal(),
    follow: () => {
      const on = get("follow").getAttribute("aria-pressed") !== "true";
      get("follow").setAttribute("aria-pressed", String(on));
      stage.setFollow(on);
    },
  };
  const clicks = {
    play: player.toggle,
    previous: () => player.toMark(-1),
    next: () => player.toMark(1),
    theme: actions.theme,
    help: actions.help,
    follow: actions.follow,
    "view-all": () => stage.look("all"),
    "view-hand": () => stage.look("hand"),
    "view-top": () => stage.look("top"),
  };
  for (const [id, act] of Object.entries(clicks)) get(id).addEventListener("click", act);
  get("speed").addEventListener("change", (event) => player.setSpeed(Number(event.target.value)));
  player.on(({ t, playing, speed, duration }) => {
    const mark = marks.findLast((m) => m.at_s <= t + 1e-3);
    get("clock").textContent = `${t.toFixed(2)} / ${duration.toFixed(2)} s`;
    get("play").textContent = playing ? "⏸" : "▶";
    get("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    get("speed").value = String(speed);
    get("happened").textContent = mark ? `${mark.at_s.toFixed(2)} s  ${mark.text}` : "";
  });
  return actions;
}
