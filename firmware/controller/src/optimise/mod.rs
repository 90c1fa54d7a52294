//! Optimisers with fixed memory: the caller evaluates, the optimiser decides where.
//!
//! An optimiser never calls the error function: it is asked for the next pose and told the error there, so that an
//! evaluation may take a tick, a rollout over the wire, or a microsecond.
//!
//! [`method`] lists them all; a caller that knows which one it wants names its type and pays for that one's memory
//! alone. Two layers: a [`search::Strategy`] decides where to look in the unit box (each free component from -1 to 1 of
//! its half width, so that metres and radians are alike), and [`search::Search`] keeps its accounts: bounds, budget,
//! goal, the best pose. Descent is built of a direction and a line search ([`descent`], [`mod@line`]).
//!
//! Where an error has no slope, differences give it ([`differences`], [`stencil`]); each is an evaluation like any other.

mod accounts;
pub mod annealing;
mod chart;
pub mod cma_es;
pub mod conjugate_gradients;
pub mod descent;
pub mod differences;
pub mod direct;
pub mod hybrid;
pub mod levenberg_marquardt;
pub mod line;
pub mod method;
pub mod multi_start;
pub mod newton;
pub mod options;
pub mod search;
pub mod starts;
pub mod steepest_descent;
pub mod stencil;
#[cfg(test)]
mod tests;

pub use levenberg_marquardt::{LevenbergMarquardt, LevenbergMarquardtConfig};
pub use method::{AnyOptimiser, Method};
pub use options::{Gradient, SearchOptions};
pub use starts::start;

use crate::error::Evaluation;
use tactus_common::pose::{Interval, PlanarPose};

/// What an optimiser wants next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// The error at this pose; answer with [`Optimiser::tell`].
    Evaluate(PlanarPose),
    /// Nothing: this is the best pose found, and why the search ended.
    Done(Found, StopReason),
}

/// The best pose of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Where the error is least.
    pub pose: PlanarPose,
    /// What the error function said there.
    pub evaluation: Evaluation,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The step or the gain has become too small to matter; also where, after steps that led down, none that matters
    /// does.
    Converged,
    /// No step makes the error smaller, however short: for a descent, none from its start.
    NoDescent,
    /// As many evaluations as allowed.
    EvaluationLimit,
    /// The error was not a finite number at the start (for a method that searches everywhere: anywhere), or had no
    /// slope although the method needs one.
    NotEvaluable,
    /// The error is below the goal.
    GoalReached,
    /// The error is the same wherever it was looked at: nothing says which way to go.
    Flat,
    /// The error falls outwards of the region only.
    AtBound,
}

impl StopReason {
    /// The name in tables, kebab-case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::NoDescent => "no-descent",
            Self::EvaluationLimit => "evaluation-limit",
            Self::NotEvaluable => "not-evaluable",
            Self::GoalReached => "goal-reached",
            Self::Flat => "flat",
            Self::AtBound => "at-bound",
        }
    }
}

/// A search for the pose with the least error.
pub trait Optimiser {
    /// What to do next. Asking again without telling gives the same answer.
    fn ask(&self) -> Ask;
    /// The answer to the last [`Ask::Evaluate`]; ignored when the search is done.
    fn tell(&mut self, evaluation: &Evaluation);
}

/// An optimiser that can be made from the options that all share.
pub trait Create: Optimiser + Sized {
    /// A search from `start`, brought within `bounds`.
    fn create(start: &PlanarPose, bounds: &Bounds, options: &SearchOptions) -> Self;
}

/// Carries a whole search through, for callers whose error is a plain function: the best pose, and why the search
/// ended. `None` for a search that has no end within 65,535 evaluations, which is none of ours.
pub fn carry_through(
    optimiser: &mut impl Optimiser,
    mut error: impl FnMut(&PlanarPose) -> Evaluation,
) -> Option<(Found, StopReason)> {
    for _ in 0..=u16::MAX {
        match optimiser.ask() {
            Ask::Evaluate(pose) => optimiser.tell(&error(&pose)),
            Ask::Done(found, reason) => return Some((found, reason)),
        }
    }
    None
}

/// The region that a search stays in: a box about the guess.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    lower: [f32; 3],
    upper: [f32; 3],
}

impl Bounds {
    /// `guess +- interval` (metres, metres, radians); a component of half width 0 is fixed at the guess.
    pub fn new(guess: &PlanarPose, interval: &Interval) -> Self {
        let (centre, half) = (guess.to_array(), interval.to_array());
        let mut bounds = Self { lower: centre, upper: centre };
        for ((lower, upper), half_width) in bounds.lower.iter_mut().zip(&mut bounds.upper).zip(half) {
            *lower -= libm::fabsf(half_width);
            *upper += libm::fabsf(half_width);
        }
        bounds
    }

    /// The nearest pose within.
    pub fn clamp(&self, pose: &PlanarPose) -> PlanarPose {
        let mut p = pose.to_array();
        for ((value, lower), upper) in p.iter_mut().zip(self.lower).zip(self.upper) {
            *value = value.max(lower).min(upper);
        }
        PlanarPose::from_array(p)
    }

    /// The pose at `unit` (each component 0..1) of the way through the region.
    pub fn at(&self, unit: [f32; 3]) -> PlanarPose {
        let mut p = self.lower;
        for (axis, value) in p.iter_mut().enumerate() {
            *value += unit[axis] * (self.upper[axis] - self.lower[axis]);
        }
        PlanarPose::from_array(p)
    }

    /// Half the width of a component (0 x, 1 y, 2 phi); 0 = fixed.
    pub fn half_width(&self, axis: usize) -> f32 {
        match (self.lower.get(axis), self.upper.get(axis)) {
            (Some(low), Some(high)) => 0.5 * (high - low),
            _ => 0.0,
        }
    }

    /// May the component move in the direction of `step` from `value`?
    fn is_free(&self, axis: usize, value: f32, step: f32) -> bool {
        self.upper[axis] > self.lower[axis]
            && !(step > 0.0 && value >= self.upper[axis])
            && !(step < 0.0 && value <= self.lower[axis])
    }
}
