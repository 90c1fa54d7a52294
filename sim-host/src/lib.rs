//! Tactus on a host: the simulated world and everything around it.

pub mod bench;
pub mod mental;
pub mod world;
