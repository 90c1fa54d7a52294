//! The error in the form that optimisers of other crates take it: `f64` over the box from -1 to 1 in half widths of the
//! interval (as ours see it), counted, and refused once the budget is spent. What was asked last is remembered, so that
//! value and slope at one pose count as one evaluation, as they do for ours.
//!
//! Methods without bounds may ask outside the box. There the error is that of the nearest pose within, plus a parabola
//! that leads back: a flat continuation would end their line searches.

use crate::Outcome;
use std::cell::RefCell;
use tactus_common::pose::PlanarPose;
use tactus_controller::error::{ErrorFunction, Geometric};
use tactus_controller::optimise::Bounds;
use tactus_tests::problems::Problem;

/// A place in the box: -1 to 1 in x, y and phi.
pub type Point = [f64; 3];

/// What the error says at a point.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// The error.
    pub error: f64,
    /// Its gradient over the point.
    pub gradient: Point,
    /// Gauss-Newton curvature, `J'WJ`: half the second derivative.
    pub curvature: [Point; 3],
}

/// The budget is spent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spent;

impl std::fmt::Display for Spent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the budget is spent")
    }
}

impl std::error::Error for Spent {}

/// The error of a problem, with a budget.
pub struct Counted<'a> {
    error: Geometric<'a>,
    bounds: Bounds,
    guess: PlanarPose,
    budget: u16,
    account: RefCell<Account>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Account {
    used: u16,
    best: Option<(f32, PlanarPose)>,
    last: Option<(Point, Told)>,
    /// Height of the parabola one half width outside: the first error that was asked for.
    steepness: Option<f64>,
}

impl<'a> Counted<'a> {
    /// The error of `problem`, to be evaluated at most `budget` times.
    pub fn new(problem: &'a Problem, budget: u16) -> Self {
        let (error, bounds) = (problem.error(), problem.prior.bounds());
        Self { error, bounds, guess: problem.prior.guess, budget, account: RefCell::default() }
    }

    /// The error at `u`.
    pub fn at(&self, u: &[f64]) -> Result<Told, Spent> {
        let u: Point = std::array::from_fn(|axis| u.get(axis).copied().unwrap_or(0.0));
        let mut account = self.account.borrow_mut();
        if let Some((point, told)) = account.last
            && point == u
        {
            return Ok(told);
        }
        if account.used >= self.budget {
            return Err(Spent);
        }
        account.used += 1;
        let within = u.map(|value| value.clamp(-1.0, 1.0));
        let pose = self.bounds.at(within.map(|value| (0.5 + 0.5 * value) as f32));
        let evaluation = self.error.evaluate(&pose);
        if account.best.is_none_or(|(least, _)| evaluation.error < least) {
            account.best = Some((evaluation.error, pose));
        }
        let error = f64::from(evaluation.error);
        let steepness = *account.steepness.get_or_insert(error);
        let mut told = Told { error, gradient: [0.0; 3], curvature: [[0.0; 3]; 3] };
        let half = |axis: usize| {
            if u[axis] == within[axis] { f64::from(self.bounds.half_width(axis)) } else { 0.0 }
        };
        if let Some(slope) = evaluation.slope {
            for row in 0..3 {
                told.gradient[row] = 2.0 * half(row) * f64::from(slope.half_gradient[row]);
                for column in 0..3 {
                    told.curvature[row][column] =
                        half(row) * half(column) * f64::from(slope.information[(row, column)]);
                }
            }
        }
        for axis in 0..3 {
            let outside = u[axis] - within[axis];
            told.error += steepness * outside * outside;
            told.gradient[axis] += 2.0 * steepness * outside;
        }
        account.last = Some((u, told));
        Ok(told)
    }

    /// The best so far.
    pub fn outcome(&self) -> Outcome {
        let account = self.account.borrow();
        Outcome { pose: account.best.map_or(self.guess, |(_, pose)| pose), evaluations: u32::from(account.used) }
    }
}
