//! The accounts of a search: what was evaluated, the best of it, and when it is enough.

use super::options::SearchOptions;
use super::{Ask, Found, StopReason};
use crate::error::Evaluation;
use tactus_common::pose::PlanarPose;

/// Budget, goal and best pose.
#[derive(Clone, Copy, Debug)]
pub struct Accounts {
    evaluations: u16,
    evaluations_max: u16,
    goal_error: f32,
    best: Option<Found>,
    stopped: Option<StopReason>,
}

impl Accounts {
    pub fn new(options: &SearchOptions) -> Self {
        Self {
            evaluations: 0,
            evaluations_max: options.evaluations_max.max(1),
            goal_error: options.goal_error,
            best: None,
            stopped: None,
        }
    }

    /// Enters an evaluation; the search stops if it reaches the goal. The first one is kept until one is better.
    pub fn enter(&mut self, pose: &PlanarPose, evaluation: &Evaluation) {
        self.evaluations += 1;
        let is_number = evaluation.error.is_finite();
        let better = match &self.best {
            None => true,
            Some(best) => {
                is_number && !(best.evaluation.error.is_finite() && best.evaluation.error <= evaluation.error)
            }
        };
        if better {
            self.best = Some(Found { pose: *pose, evaluation: *evaluation });
        }
        if is_number && evaluation.error < self.goal_error {
            self.stop(StopReason::GoalReached);
        }
    }

    /// Ends the search, unless it has ended.
    pub fn stop(&mut self, reason: StopReason) {
        let is_number = self.best.is_some_and(|best| best.evaluation.error.is_finite());
        let reason = if is_number { reason } else { StopReason::NotEvaluable };
        self.stopped = self.stopped.or(Some(reason));
    }

    /// Ends the search if nothing may be evaluated any more.
    pub fn stop_at_limit(&mut self) {
        if self.evaluations >= self.evaluations_max {
            self.stop(StopReason::EvaluationLimit);
        }
    }

    pub fn is_done(&self) -> bool {
        self.stopped.is_some()
    }

    pub fn evaluations(&self) -> u16 {
        self.evaluations
    }

    pub fn best(&self) -> Option<Found> {
        self.best
    }

    /// The answer to an `ask` whose next evaluation would be at `next`.
    pub fn answer(&self, next: impl FnOnce() -> PlanarPose) -> Ask {
        match (self.stopped, self.best) {
            (Some(reason), Some(best)) => Ask::Done(best, reason),
            _ => Ask::Evaluate(next()),
        }
    }
}
