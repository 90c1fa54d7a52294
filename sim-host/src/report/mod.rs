//! What people and tools see: of a mission progress, a closing summary, JSON; of experiments a page.

pub mod explain;
pub mod html;
pub mod progress;
pub mod summary;
pub mod terminal;
