//! The host side of Tactus: the simulated world, the planner, the mental world, and the `tactus` command.

pub mod cli;
pub mod experiment;
pub mod host;
pub mod mental;
pub mod mission;
pub mod plan;
pub mod report;
pub mod scenario;
pub mod world;
