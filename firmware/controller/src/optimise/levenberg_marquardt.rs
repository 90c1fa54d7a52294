//! Levenberg-Marquardt within bounds: damped Gauss-Newton steps on a sum of squares.
//!
//! Step `(J'WJ + lambda D) d = -J'Wr` with `D = diag(J'WJ)` (Marquardt 1963), components at a bound that would be
//! crossed held there. The error may be robust: weights enter through the error function's `J'WJ` and `J'Wr`.

use super::{Ask, Bounds, Found, Optimiser, StopReason};
use crate::error::{Evaluation, Slope};
use nalgebra::{Matrix3, Vector3};
use tactus_common::pose::PlanarPose;

/// Parameters of [`LevenbergMarquardt`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevenbergMarquardtConfig {
    /// Most evaluations of one search.
    pub evaluations_max: u16,
    /// Damping of the first step, relative to the curvature.
    pub damping_start: f32,
    /// A step below this in x, y (metres) and, over the lever arm, in phi ends the search.
    pub step_min_m: f32,
    /// Longest step in x or y, metres: linear models of contact reach no further.
    pub step_max_m: f32,
    /// Distance at which a turn counts as a shift, metres per radian.
    pub lever_m: f32,
}

impl Default for LevenbergMarquardtConfig {
    fn default() -> Self {
        Self { evaluations_max: 24, damping_start: 1e-2, step_min_m: 2e-5, step_max_m: 0.03, lever_m: 0.1 }
    }
}

/// Curvature given to a direction that no evidence bears on, so that the damped system can be solved: the information
/// of one residual with a standard deviation of 1 m.
const CURVATURE_MIN: f32 = 1.0;
/// Damping beyond which no step is worth a try.
const DAMPING_MAX: f32 = 1e6;

/// The search. About 150 bytes.
#[derive(Clone, Debug, Default)]
pub struct LevenbergMarquardt {
    config: LevenbergMarquardtConfig,
    bounds: Bounds,
    best: Option<Found>,
    trial: PlanarPose,
    damping: f32,
    evaluations: u16,
    stopped: Option<StopReason>,
}

impl LevenbergMarquardt {
    /// A search from `start`, brought within `bounds`.
    pub fn new(config: &LevenbergMarquardtConfig, bounds: &Bounds, start: &PlanarPose) -> Self {
        Self {
            config: *config,
            bounds: *bounds,
            best: None,
            trial: bounds.clamp(start),
            damping: config.damping_start,
            evaluations: 0,
            stopped: None,
        }
    }

    /// Evaluations told so far.
    pub fn evaluations(&self) -> u16 {
        self.evaluations
    }

    /// The next trial from the best pose, or why there is none.
    fn next_trial(&self, best: &Found, slope: &Slope) -> Result<PlanarPose, StopReason> {
        let here = best.pose.to_array();
        let mut held = [false; 3];
        // A held component leaves the system; that may turn another one outwards, hence at most three rounds.
        for _ in 0..3 {
            let step = self.damped_step(slope, &held).ok_or(StopReason::NotEvaluable)?;
            let mut crossed = false;
            for axis in 0..3 {
                if !held[axis] && !self.bounds.is_free(axis, here[axis], step[axis]) {
                    held[axis] = true;
                    crossed = true;
                }
            }
            if !crossed {
                let mut next = here;
                for axis in 0..3 {
                    next[axis] += step[axis];
                }
                return Ok(self.bounds.clamp(&PlanarPose::from_array(next)));
            }
        }
        Err(StopReason::Converged)
    }

    /// The damped step without the held components, shortened to the longest one allowed.
    fn damped_step(&self, slope: &Slope, held: &[bool; 3]) -> Option<Vector3<f32>> {
        let mut system: Matrix3<f32> = slope.information;
        let mut right = -slope.half_gradient;
        for axis in 0..3 {
            let scale = if axis == 2 { self.config.lever_m * self.config.lever_m } else { 1.0 };
            system[(axis, axis)] +=
                self.damping * (system[(axis, axis)] + CURVATURE_MIN * scale) + CURVATURE_MIN * scale;
        }
        for axis in 0..3 {
            if held[axis] {
                for other in 0..3 {
                    system[(axis, other)] = 0.0;
                    system[(other, axis)] = 0.0;
                }
                system[(axis, axis)] = 1.0;
                right[axis] = 0.0;
            }
        }
        let step = system.cholesky()?.solve(&right);
        if !step.iter().all(|v| v.is_finite()) {
            return None;
        }
        let longest_m = libm::fabsf(step.x).max(libm::fabsf(step.y)).max(libm::fabsf(step.z) * self.config.lever_m);
        Some(if longest_m > self.config.step_max_m { step * (self.config.step_max_m / longest_m) } else { step })
    }

    fn step_m(&self, from: &PlanarPose, to: &PlanarPose) -> f32 {
        libm::fabsf(to.x_m - from.x_m)
            .max(libm::fabsf(to.y_m - from.y_m))
            .max(libm::fabsf(to.phi_rad - from.phi_rad) * self.config.lever_m)
    }

    /// Takes or refuses the evaluated trial; says why to stop, if to stop.
    fn judge(&mut self, evaluation: &Evaluation) -> Option<StopReason> {
        let candidate = Found { pose: self.trial, evaluation: *evaluation };
        match self.best {
            None => {
                if !evaluation.is_finite() || evaluation.slope.is_none() {
                    self.best = Some(candidate);
                    return Some(StopReason::NotEvaluable);
                }
                self.best = Some(candidate);
            }
            Some(best) => {
                let better = evaluation.is_finite() && evaluation.error < best.evaluation.error;
                let step_m = self.step_m(&best.pose, &self.trial);
                if better {
                    let gain = best.evaluation.error - evaluation.error;
                    self.best = Some(candidate);
                    self.damping = (self.damping * 0.2).max(1e-6);
                    if step_m < self.config.step_min_m || gain < 1e-4 * (1e-2 + evaluation.error) {
                        return Some(StopReason::Converged);
                    }
                } else {
                    if step_m < self.config.step_min_m {
                        return Some(StopReason::Converged);
                    }
                    self.damping = (self.damping * 8.0).max(1e-2);
                    if self.damping > DAMPING_MAX {
                        return Some(StopReason::NoDescent);
                    }
                }
            }
        }
        (self.evaluations >= self.config.evaluations_max).then_some(StopReason::EvaluationLimit)
    }
}

impl Optimiser for LevenbergMarquardt {
    fn ask(&self) -> Ask {
        match (self.stopped, self.best) {
            (Some(reason), Some(best)) => Ask::Done(best, reason),
            _ => Ask::Evaluate(self.trial),
        }
    }

    fn tell(&mut self, evaluation: &Evaluation) {
        if self.stopped.is_some() {
            return;
        }
        self.evaluations += 1;
        self.stopped = self.judge(evaluation);
        if self.stopped.is_none()
            && let Some(best) = self.best
        {
            match best.evaluation.slope {
                Some(slope) => match self.next_trial(&best, &slope) {
                    Ok(trial) => self.trial = trial,
                    Err(reason) => self.stopped = Some(reason),
                },
                None => self.stopped = Some(StopReason::NotEvaluable),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_common::pose::Interval;

    /// Sum of squares with the minimum at `(0.02, -0.01, 0.1)` and a bend in it.
    fn bowl(p: &PlanarPose) -> Evaluation {
        let (x, y, phi) = (p.x_m - 0.02, p.y_m + 0.01, p.phi_rad - 0.1);
        let residuals = [1000.0 * (x + 2.0 * phi * phi), 1000.0 * y, 100.0 * (phi + x * 3.0)];
        let rows =
            [Vector3::new(1000.0, 0.0, 4000.0 * phi), Vector3::new(0.0, 1000.0, 0.0), Vector3::new(300.0, 0.0, 100.0)];
        let mut slope = Slope { half_gradient: Vector3::zeros(), information: Matrix3::zeros() };
        let mut error = 0.0;
        for (r, j) in residuals.iter().zip(rows) {
            error += r * r;
            slope.half_gradient += j * *r;
            slope.information += j * j.transpose();
        }
        Evaluation { error, slope: Some(slope) }
    }

    fn solve(interval: Interval, start: PlanarPose) -> (Found, StopReason, u16) {
        let bounds = Bounds::new(&PlanarPose::default(), &interval);
        let mut search = LevenbergMarquardt::new(&LevenbergMarquardtConfig::default(), &bounds, &start);
        for _ in 0..100 {
            match search.ask() {
                Ask::Evaluate(pose) => search.tell(&bowl(&pose)),
                Ask::Done(found, reason) => return (found, reason, search.evaluations()),
            }
        }
        panic!("no end");
    }

    #[test]
    fn the_minimum_of_a_bent_bowl_is_found() {
        let wide = Interval { x_m: 0.1, y_m: 0.1, phi_rad: 0.5 };
        let (found, reason, evaluations) = solve(wide, PlanarPose::new(-0.08, 0.09, -0.4));
        assert_eq!(reason, StopReason::Converged);
        assert!(found.evaluation.error < 1e-3, "{found:?} after {evaluations}");
        assert!((found.pose.phi_rad - 0.1).abs() < 1e-3);
    }

    #[test]
    fn a_component_known_exactly_never_moves() {
        let (found, _, _) = solve(Interval { x_m: 0.1, y_m: 0.1, phi_rad: 0.0 }, PlanarPose::default());
        assert_eq!(found.pose.phi_rad, 0.0);
        assert!((found.pose.y_m + 0.01).abs() < 1e-4);
    }

    #[test]
    fn the_search_stays_within_its_bounds_and_slides_along_them() {
        let (found, _, _) = solve(Interval { x_m: 0.01, y_m: 0.1, phi_rad: 0.5 }, PlanarPose::new(-0.01, 0.05, -0.3));
        assert!(found.pose.x_m.abs() <= 0.01 + 1e-7);
        assert!((found.pose.y_m + 0.01).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn an_error_that_is_no_number_ends_the_search() {
        let bounds = Bounds::new(&PlanarPose::default(), &Interval { x_m: 0.1, y_m: 0.1, phi_rad: 0.1 });
        let mut search = LevenbergMarquardt::new(&LevenbergMarquardtConfig::default(), &bounds, &PlanarPose::default());
        search.tell(&Evaluation { error: f32::NAN, slope: None });
        assert!(matches!(search.ask(), Ask::Done(_, StopReason::NotEvaluable)));
    }
}
