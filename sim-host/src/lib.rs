//! The host side of Tactus: the simulated world, the planner, the mental world, and the `tactus` command.
//!
//! * [`world`]: rapier, the robot's drives and sensors, noise and mismatch. [`mental`]: rollouts of a touch.
//! * [`plan`]: collision-free, timed motions of the arm.
//! * [`host`]: the world's end of the wire ([`hooks`]: for tests). [`mission`]: one mission from options to report.
//! * [`experiment`]: many missions. [`report`]: what people and tools see. [`cli`], [`scenario`]: what they say.

pub mod cli;
pub mod experiment;
pub mod hooks;
pub mod host;
pub mod mental;
pub mod mission;
pub mod plan;
pub mod report;
pub mod scenario;
pub mod world;
