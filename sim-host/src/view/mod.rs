//! The page of one run: what its recording holds, in 3D, on a time line and in plots, without a network.
//!
//! * [`replay`]: from a recording to a payload. [`frames`], [`bodies`], [`taxels`], [`plots`], [`story`]: its parts.
//! * [`payload`]: what the page's script gets to know. [`packed`]: many numbers in little room.
//! * [`page`]: the page around it. Its script comes from `sim-host/view/` (`cargo xtask page`).
//! * [`server`]: shows it to a browser on this machine.

pub mod bodies;
pub mod frames;
pub mod packed;
pub mod page;
pub mod payload;
pub mod plots;
pub mod replay;
pub mod server;
pub mod story;
pub mod taxels;
#[cfg(test)]
mod tests;

pub use replay::Replay;
