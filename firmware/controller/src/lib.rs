//! The Tactus controller: guarded motion, touch evidence, pose update, mission and safety.
//!
//! [`controller`] is one tick: look, decide, plan, act; read it first. [`node`] puts it on a CAN bus;
//! [`puck_driver`] puts it on the one of Barrett's own motor controllers.
//!
//! * Motion: [`executor`] plays trajectories, [`control`] turns references into torques, [`onset`] feels contacts.
//! * Touch: [`touch`] lists and chooses touches, [`evidence`] and [`felt_touch`] keep what was felt, [`predict`] foretells
//!   it.
//! * Pose: [`error`] and [`optimise`] fit it, sliced over ticks by [`update`], into a [`belief`].
//! * Decisions: [`mission`] (what next), [`supervisor`] (what is unsafe).
//!
//! `no_std`, no heap, no clock, every loop bounded: the caller owns time, bus and memory.
#![no_std]
#![forbid(unsafe_code)]

pub mod belief;
pub mod control;
pub mod controller;
pub mod error;
pub mod evidence;
pub mod executor;
pub mod felt_touch;
pub mod mission;
pub mod node;
pub mod onset;
pub mod optimise;
pub mod predict;
pub mod puck_driver;
pub mod slip;
mod sort;
pub mod supervisor;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod touch;
pub mod update;
pub mod work;
