//! What every board needs around the controller's node, and what is no business of the controller: time as the
//! board's clock gives it, and bytes that arrive while it computes.
//!
//! * [`Shell`]: hands frames to the node, announces it while it waits for a mission, and makes it safe when the world
//!   falls silent.
//! * [`ring`]: bytes from an interrupt to the loop.
//! * [`millis`]: time from an interrupt to the loop.
//! * [`meter`]: the longest tick.
//!
//! A board adds its registers, its loop and its panic handler.
#![no_std]
#![forbid(unsafe_code)]

pub mod meter;
pub mod millis;
pub mod ring;
mod shell;

pub use shell::{ANNOUNCEMENT_MS, REALTIME_SILENCE_MS, SILENCE_MS, Shell};
