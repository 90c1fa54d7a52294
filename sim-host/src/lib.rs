//! The host side of Tactus.
//!
//! * [`plan`]: collision-free, timed motions of the arm.

pub mod plan;
