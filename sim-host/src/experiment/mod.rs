//! Experiments over many missions, and benches.

pub mod bench;
pub mod trials;
