//! Optimisers with fixed memory: the caller evaluates, the optimiser decides where.
//!
//! An optimiser never calls the error function: it is asked for the next pose and told the error there, so that an
//! evaluation may take a tick, a rollout over the wire, or a microsecond.

pub mod levenberg_marquardt;
pub mod starts;

pub use levenberg_marquardt::{LevenbergMarquardt, LevenbergMarquardtConfig};
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
    /// The step or the gain has become too small to matter.
    Converged,
    /// No step makes the error smaller, however short.
    NoDescent,
    /// As many evaluations as allowed.
    EvaluationLimit,
    /// The error was not a finite number at the start, or had no slope although the method needs one.
    NotEvaluable,
}

/// A search for the pose with the least error.
pub trait Optimiser {
    /// What to do next. Asking again without telling gives the same answer.
    fn ask(&self) -> Ask;
    /// The answer to the last [`Ask::Evaluate`]; ignored when the search is done.
    fn tell(&mut self, evaluation: &Evaluation);
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
