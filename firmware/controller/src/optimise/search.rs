//! One search: a strategy that decides where to look in the unit box, and the accounts that bound it.

use super::accounts::Accounts;
use super::chart::{Chart, into_box};
use super::options::{Gradient, SearchOptions};
use super::{Ask, Bounds, Create, Found, Optimiser, StopReason};
use crate::error::Evaluation;
use nalgebra::{Matrix3, Vector3};
use tactus_common::pose::PlanarPose;

/// A point of the unit box: each free component -1..1, what is beyond them 0.
pub type Point = Vector3<f32>;

/// Slope and curvature of an error at a point, per half width; 0 beyond the free components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// First derivatives.
    pub gradient: Point,
    /// Second derivatives (for an error that is a sum of squares: the Gauss-Newton part of them).
    pub curvature: Matrix3<f32>,
}

/// An evaluation as strategies see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where.
    pub point: Point,
    /// The error; infinite where it is no finite number.
    pub error: f32,
    /// The error function's own slope, if it has one and the options ask for it.
    pub model: Option<Model>,
}

/// What a strategy knows at its start.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The first point to be evaluated.
    pub start: Point,
    /// Free components, 1..=3.
    pub free: usize,
    /// Steps of differences, in half widths.
    pub steps: Point,
    /// The options as given.
    pub options: SearchOptions,
}

/// What a strategy does after an evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// Evaluate here; the search brings it into the box.
    Try(Point),
    /// Nothing more to do.
    Stop(StopReason),
}

/// Decides where to look. Bounded work a call; the number of calls is bounded by [`Search`].
pub trait Strategy {
    /// A strategy that is to be told the sample at `setup.start` first.
    fn new(setup: &Setup) -> Self;
    /// The next point after the sample at the last one.
    fn next(&mut self, sample: &Sample) -> Next;
}

/// A strategy within bounds and budget.
#[derive(Clone, Debug)]
pub struct Search<S> {
    chart: Chart,
    accounts: Accounts,
    uses_slope: bool,
    trial: Point,
    strategy: S,
}

impl<S> Search<S> {
    /// Evaluations told so far.
    pub fn evaluations(&self) -> u16 {
        self.accounts.evaluations()
    }

    /// The best so far.
    pub fn best(&self) -> Option<Found> {
        self.accounts.best()
    }
}

impl<S: Strategy> Create for Search<S> {
    fn create(start: &PlanarPose, bounds: &Bounds, options: &SearchOptions) -> Self {
        let chart = Chart::new(bounds, start);
        let start = chart.point(start);
        let setup = Setup { start, free: chart.free(), steps: chart.lengths(options.steps), options: *options };
        Self {
            chart,
            accounts: Accounts::new(options),
            uses_slope: options.gradient == Gradient::Analytic,
            trial: start,
            strategy: S::new(&setup),
        }
    }
}

impl<S: Strategy> Optimiser for Search<S> {
    fn ask(&self) -> Ask {
        self.accounts.answer(|| self.chart.pose(&self.trial))
    }

    fn tell(&mut self, evaluation: &Evaluation) {
        if self.accounts.is_done() {
            return;
        }
        self.accounts.enter(&self.chart.pose(&self.trial), evaluation);
        if self.chart.free() == 0 {
            self.accounts.stop(StopReason::Converged);
        }
        if self.accounts.is_done() {
            return;
        }
        let sample = Sample {
            point: self.trial,
            error: if evaluation.error.is_finite() { evaluation.error } else { f32::INFINITY },
            model: match &evaluation.slope {
                Some(slope) if self.uses_slope && evaluation.is_finite() => Some(self.chart.model(slope)),
                _ => None,
            },
        };
        match self.strategy.next(&sample) {
            Next::Try(point) => self.trial = into_box(&point),
            Next::Stop(reason) => self.accounts.stop(reason),
        }
        self.accounts.stop_at_limit();
    }
}
