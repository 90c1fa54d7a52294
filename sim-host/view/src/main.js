// The replay of one run: reads the payload, builds all views, keeps them at the same moment.

import "./faults.js";
import { wishes } from "./address.js";
import { makeBelief } from "./belief.js";
import { addBodies } from "./bodies.js";
import { connect } from "./buttons.js";
import { makeColourMap } from "./colours.js";
import { makeForces } from "./forces.js";
import { makeFrames } from "./frames.js";
import { addGoal } from "./goal.js";
import { addGround } from "./ground.js";
import { listen } from "./keys.js";
import { makePadPanel } from "./padpanel.js";
import { makePads } from "./pads.js";
import { makePlayer } from "./player.js";
import { makePlot } from "./plot.js";
import { makeReadout } from "./readout.js";
import { makeStage } from "./stage.js";
import { makeTaxels } from "./taxels.js";
import { setTheme } from "./theme.js";
import { makeTimeline } from "./timeline.js";

const get = (id) => document.getElementById(id);
const run = JSON.parse(get("run").textContent);
const wish = wishes();
if (wish.theme !== null) setTheme(wish.theme);

const player = makePlayer(run.duration_s, run.marks);
const frames = makeFrames(run.frames);
const colourMap = makeColourMap(run.colour_map, run.bright_n_cm2);
// The robot's base is the first of its links.
const stage = makeStage(get("canvas"), frames.all[0], frames.all[run.palm]);
stage.scene.add(...frames.all);
addGround(stage);
if (run.goal !== null) addGoal(stage, run.goal);
const belief = makeBelief(stage, run.belief);
addBodies(stage, run.bodies, frames, { belief: belief.group });
const forces = makeForces(stage, run.contacts);
const pads = makePads(run.pads, [makeTaxels(run.pads, frames, colourMap), makePadPanel(get("pads"), run.pads, colourMap)]);
const plots = run.plots.map((plot) => makePlot(get("plots"), plot, player));
const timeline = makeTimeline(get("timeline"), run, player);
const truth = run.bodies.find((body) => body.role === "truth");
const readout = makeReadout(get("readout"), run.phases, truth ? frames.all[truth.frame] : null);
document.querySelector("#legend .pressure").style.background = colourMap.gradient;
document.querySelector("#legend .pressure").parentElement.lastChild.textContent = `pad pressure 0, ${run.bright_n_cm2 / 4}, ${run.bright_n_cm2} N/cm²`;

player.on(({ t }) => {
  frames.at(t);
  stage.scene.updateMatrixWorld();
  stage.follow();
  const now = belief.at(t);
  forces.at(t);
  pads.at(t);
  plots.forEach((plot) => plot.at(player));
  timeline.at(player);
  readout.at(t, now);
  stage.draw();
});
listen({ player, stage, actions: connect(player, stage, run.marks) });
addEventListener("hashchange", () => player.seek(wishes().t));
player.seek(wish.t);
stage.look(wish.view);
// Drawn once: whoever waits for the page sees it.
requestAnimationFrame(() => {
  performance.mark("ready");
  document.documentElement.dataset.ready = "true";
});
