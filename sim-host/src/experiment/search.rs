//! One search for the pose of least error, by any optimiser, and what it cost.

use std::time::Instant;
use tactus_common::pose::PlanarPose;
use tactus_controller::error::Evaluation;
use tactus_controller::optimise::method::AnyOptimiser;
use tactus_controller::optimise::{Ask, Bounds, Method, Optimiser, SearchOptions, StopReason};

/// The end of a search.
#[derive(Clone, Debug)]
pub struct Searched {
    /// The best pose.
    pub pose: PlanarPose,
    /// The error there; infinite if none was a number.
    pub error: f32,
    /// Poses evaluated.
    pub evaluations: u32,
    /// Wall time, evaluations included, seconds.
    pub time_s: f64,
    /// Why it ended.
    pub reason: StopReason,
}

/// Searches from `start` within `bounds`.
pub fn search(
    method: Method,
    start: &PlanarPose,
    bounds: &Bounds,
    options: &SearchOptions,
    mut evaluate: impl FnMut(&PlanarPose) -> Evaluation,
) -> Searched {
    let started = Instant::now();
    let mut optimiser = AnyOptimiser::new(method, start, bounds, options).expect("the host has all optimisers");
    let (found, reason) = loop {
        match optimiser.ask() {
            Ask::Evaluate(pose) => optimiser.tell(&evaluate(&pose)),
            Ask::Done(found, reason) => break (found, reason),
        }
    };
    Searched {
        pose: found.pose,
        error: found.evaluation.error,
        evaluations: u32::from(optimiser.evaluations()),
        time_s: started.elapsed().as_secs_f64(),
        reason,
    }
}
