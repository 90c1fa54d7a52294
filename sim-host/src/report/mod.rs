//! What people and tools see of a mission: progress, a closing summary, JSON.

pub mod progress;
pub mod summary;
pub mod terminal;
