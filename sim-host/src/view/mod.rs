//! The page of one run: what its recording holds, in 3D, on a time line and in plots, without a network.
//!
//! * [`payload`]: what the page's script gets to know. [`packed`]: many numbers in little room.
//! * [`page`]: the page around it. Its script comes from `sim-host/view/` (`cargo xtask page`).

pub mod packed;
pub mod page;
pub mod payload;
