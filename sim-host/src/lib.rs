//! The host side of Tactus: the simulated world, the planner, the mental world, and the `tactus` command.
//!
//! * [`solid`]: shapes as the physics library has them. [`world`]: rapier, the robot's drives and sensors, noise and mismatch. [`mental`]: rollouts of a touch.
//! * [`plan`]: collision-free, timed motions of the arm.
//! * [`host`]: the world's end, tick by tick ([`observer`]: who watches). [`post`]: its messages. [`wire`]: what carries them ([`hooks`]: for tests).
//! * [`advisor`]: answers the controller's questions; [`desk`]: when. [`mission`]: one mission from options to report. [`serve`]: for
//!   controllers that come by themselves. [`controller_process`]: one that is started here.
//! * [`recording`]: all of a run in one file.
//! * [`experiment`]: many missions. [`report`]: what people and tools see. [`cli`], [`scenario`]: what they say.

// What is printed goes through `tactus_hil::say`, whose reader may be gone.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod advisor;
pub mod cli;
pub mod controller_process;
pub mod desk;
pub mod experiment;
pub mod hooks;
pub mod host;
pub mod mental;
pub mod method;
pub mod mission;
pub mod observer;
pub mod plan;
pub mod post;
pub mod recording;
pub mod report;
pub mod scenario;
pub mod serve;
pub mod solid;
pub mod view;
pub mod wire;
pub mod world;
