//! Experiments over many missions and poses, and benches.
//!
//! [`trials`]: whole missions over seeds. [`surface`] and [`converge`]: the published experiments, for any method.
//! [`compare`]: all methods on the same evidence. What they share: [`conduct`] (conditions, results,
//! record), [`jobs`] (threads, progress, going on after an
//! interruption), [`capture`] (evidence felt in a mission), [`replan`] (the published formulation), [`method`], [`grid`],
//! [`observability`], [`record`] (what goes beside the numbers).

pub mod bench;
pub mod capture;
pub mod compare;
pub mod conduct;
pub mod converge;
pub mod grid;
pub mod jobs;
pub mod method;
pub mod observability;
pub mod record;
pub mod replan;
pub mod search;
pub mod surface;
pub mod trials;
