//! Levenberg-Marquardt from several starts: the given one, then a low-discrepancy sequence over the region.
//!
//! Each start is a search of [`super::levenberg_marquardt`] (Levenberg 1944, Marquardt 1963), which needs slopes of a
//! sum of squares. Where the error has none, a stencil of differences gives gradient and curvature at each pose that is
//! better than the last (made convex, as a sum of squares would be): a damped Newton method by Goldfeld, Quandt & Trotter
//! (1966). A pose that is no better needs no slope and costs one evaluation.

use super::accounts::Accounts;
use super::chart::Chart;
use super::options::{Gradient, SearchOptions};
use super::search::{Model, Point};
use super::stencil::{Stencil, made_convex};
use super::{Ask, Bounds, Create, Found, LevenbergMarquardt, LevenbergMarquardtConfig, Optimiser, StopReason, start};
use crate::error::{Evaluation, Slope};
use nalgebra::Matrix3;
use tactus_common::pose::PlanarPose;

/// Poses that one start may try; a bent valley takes this many.
const TRIALS_MAX: u16 = 60;

/// The search. About 430 bytes.
#[derive(Clone, Debug)]
pub struct LevenbergMarquardtStarts {
    chart: Chart,
    bounds: Bounds,
    steps: Point,
    options: SearchOptions,
    accounts: Accounts,
    search: LevenbergMarquardt,
    /// The next start's number.
    next: u16,
    /// The least error of the present start.
    least: f32,
    /// The slope in the making, and the error at its pose.
    stencil: Option<(Stencil, f32)>,
    /// The least end of a start, and why it ended.
    end: Option<(f32, StopReason)>,
    saw_slope: bool,
}

impl LevenbergMarquardtStarts {
    /// Evaluations told so far.
    pub fn evaluations(&self) -> u16 {
        self.accounts.evaluations()
    }

    /// The best so far.
    pub fn best(&self) -> Option<Found> {
        self.accounts.best()
    }

    fn trial(&self) -> PlanarPose {
        match (&self.stencil, self.search.ask()) {
            (Some((stencil, _)), _) => self.chart.pose(&stencil.ask()),
            (None, Ask::Evaluate(pose)) => pose,
            (None, Ask::Done(found, _)) => found.pose,
        }
    }

    /// The evaluation for the search, once it has its slope.
    fn with_slope(&mut self, evaluation: &Evaluation) -> Option<Evaluation> {
        if let Some((stencil, error)) = &mut self.stencil {
            let (model, is_flat) = stencil.tell(evaluation.error)?;
            let error = *error;
            self.stencil = None;
            self.saw_slope |= !is_flat;
            let slope = if is_flat { None } else { self.convex(&model) };
            return Some(Evaluation { error, slope });
        }
        let is_usable =
            self.options.gradient == Gradient::Analytic && evaluation.slope.is_some() && evaluation.is_finite();
        let is_better = evaluation.error.is_finite() && evaluation.error < self.least;
        if is_better {
            self.least = evaluation.error;
        }
        self.saw_slope |= is_usable;
        if is_usable || !is_better {
            return Some(*evaluation);
        }
        if let Ask::Evaluate(pose) = self.search.ask() {
            let two_sided = self.options.gradient != Gradient::OneSided;
            let at = self.chart.point(&pose);
            let stencil = Stencil::new(&at, evaluation.error, &self.steps, self.chart.free(), two_sided);
            self.stencil = Some((stencil, evaluation.error));
        }
        None
    }

    /// The slope of a sum of squares that is like `model`.
    fn convex(&self, model: &Model) -> Option<Slope> {
        let mut curvature = model.curvature;
        let scale = curvature.norm();
        for axis in self.chart.free()..3 {
            curvature[(axis, axis)] = scale;
        }
        // Without any curvature the damping alone decides about the step.
        let mut curvature = made_convex(&curvature).unwrap_or_else(Matrix3::zeros);
        for axis in self.chart.free()..3 {
            for other in 0..3 {
                curvature[(axis, other)] = 0.0;
                curvature[(other, axis)] = 0.0;
            }
        }
        Some(self.chart.slope(&Model { gradient: model.gradient, curvature }))
    }

    fn finish_start(&mut self, found: &Found, reason: StopReason) {
        let error = found.evaluation.error;
        if self.end.is_none_or(|(least, _)| error < least || !least.is_finite()) {
            self.end = Some((error, reason));
        }
        if self.next < self.options.starts {
            let from = self.bounds.at(start(self.next));
            self.next += 1;
            self.begin(&from);
        } else {
            let reason = self.end.map_or(reason, |(_, reason)| reason);
            self.accounts.stop(if self.saw_slope { reason } else { StopReason::Flat });
        }
    }

    fn begin(&mut self, from: &PlanarPose) {
        let config = LevenbergMarquardtConfig { evaluations_max: TRIALS_MAX, ..LevenbergMarquardtConfig::default() };
        self.search = LevenbergMarquardt::new(&config, &self.bounds, from);
        self.least = f32::INFINITY;
    }
}

impl Create for LevenbergMarquardtStarts {
    fn create(start: &PlanarPose, bounds: &Bounds, options: &SearchOptions) -> Self {
        let chart = Chart::new(bounds, start);
        let mut search = Self {
            chart,
            bounds: *bounds,
            steps: chart.lengths(options.steps),
            options: *options,
            accounts: Accounts::new(options),
            search: LevenbergMarquardt::default(),
            next: 1,
            least: f32::INFINITY,
            stencil: None,
            end: None,
            saw_slope: false,
        };
        search.begin(start);
        search
    }
}

impl Optimiser for LevenbergMarquardtStarts {
    fn ask(&self) -> Ask {
        self.accounts.answer(|| self.trial())
    }

    fn tell(&mut self, evaluation: &Evaluation) {
        if self.accounts.is_done() {
            return;
        }
        self.accounts.enter(&self.trial(), evaluation);
        if self.chart.free() == 0 {
            self.accounts.stop(StopReason::Converged);
        }
        if !self.accounts.is_done()
            && let Some(complete) = self.with_slope(evaluation)
        {
            self.search.tell(&complete);
            if let Ask::Done(found, reason) = self.search.ask() {
                self.finish_start(&found, reason);
            }
        }
        self.accounts.stop_at_limit();
    }
}
