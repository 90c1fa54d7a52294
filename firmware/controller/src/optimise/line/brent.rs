//! Brent's line search: parabolas through the best three points where they can be trusted, golden sections elsewhere.
//!
//! Brent (1973), chapter 5. A parabola is trusted if its minimum lies within the bracket and moves by less than half of
//! the step before the last.

use super::{Bracket, GOLDEN, Probe, REFINEMENTS_MAX, Refinement, TOLERANCE};

/// Part of the tolerance that Brent's method calls `tol`: it stops with the bracket's ends within twice that.
const HALF: f32 = 0.5;

/// Brent's search. About 60 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Brent {
    low: f32,
    high: f32,
    best: Probe,
    second: Probe,
    third: Probe,
    /// The last step and the one before.
    step: f32,
    step_before: f32,
    trial: f32,
    shortest: f32,
    left: u8,
}

impl Brent {
    fn tolerance(&self) -> f32 {
        HALF * (TOLERANCE * self.best.at).max(self.shortest)
    }

    fn is_narrow(&self) -> bool {
        let middle = 0.5 * (self.low + self.high);
        let off = libm::fabsf(self.best.at - middle);
        off <= 2.0 * self.tolerance() - 0.5 * (self.high - self.low) || self.left == 0
    }

    /// The step to the minimum of the parabola through the three best points, if it can be trusted.
    fn parabola(&self) -> Option<f32> {
        let (x, w, v) = (self.best, self.second, self.third);
        let r = (x.at - w.at) * (x.error - v.error);
        let q = (x.at - v.at) * (x.error - w.error);
        let denominator = 2.0 * (q - r);
        let step = ((x.at - w.at) * r - (x.at - v.at) * q) / denominator;
        let target = x.at + step;
        let is_trusted = step.is_finite()
            && libm::fabsf(step) < HALF * libm::fabsf(self.step_before)
            && target > self.low
            && target < self.high;
        is_trusted.then_some(step)
    }

    fn plan(&mut self) {
        let tolerance = self.tolerance();
        let x = self.best.at;
        let wider = if x >= 0.5 * (self.low + self.high) { self.low - x } else { self.high - x };
        let parabola = if libm::fabsf(self.step_before) > tolerance { self.parabola() } else { None };
        let before = self.step;
        self.step = match parabola {
            Some(step) => {
                let target = x + step;
                // Not next to an end: the bracket would hardly shrink.
                if target - self.low < 2.0 * tolerance || self.high - target < 2.0 * tolerance {
                    libm::copysignf(tolerance, wider)
                } else {
                    step
                }
            }
            None => GOLDEN * wider,
        };
        self.step_before = if parabola.is_some() { before } else { wider };
        if libm::fabsf(self.step) < tolerance {
            self.step = libm::copysignf(tolerance, self.step);
        }
        self.trial = (x + self.step).max(self.low).min(self.high);
    }
}

impl Refinement for Brent {
    fn new(bracket: &Bracket, shortest: f32) -> Self {
        let Bracket { low, middle, high } = *bracket;
        let (second, third) = if low.error < high.error { (low, high) } else { (high, low) };
        let width = high.at - low.at;
        let mut search = Self {
            low: low.at,
            high: high.at,
            best: middle,
            second,
            third,
            // The bracket is new: any parabola within it is welcome.
            step: width,
            step_before: 2.0 * width,
            trial: 0.0,
            shortest,
            left: REFINEMENTS_MAX,
        };
        search.plan();
        search
    }

    fn ask(&self) -> f32 {
        self.trial
    }

    fn tell(&mut self, error: f32) -> bool {
        let trial = Probe { at: self.trial, error };
        if error <= self.best.error {
            if trial.at >= self.best.at {
                self.low = self.best.at
            } else {
                self.high = self.best.at
            }
            self.third = self.second;
            self.second = self.best;
            self.best = trial;
        } else {
            if trial.at < self.best.at {
                self.low = trial.at
            } else {
                self.high = trial.at
            }
            if error <= self.second.error {
                self.third = self.second;
                self.second = trial;
            } else if error <= self.third.error {
                self.third = trial;
            }
        }
        self.left = self.left.saturating_sub(1);
        let is_done = self.is_narrow();
        self.plan();
        is_done
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Bracketed, GoldenSection, bench};
    use super::*;

    #[test]
    fn a_parabola_needs_fewer_evaluations_than_golden_sections_do() {
        let (mut brents, mut goldens) = (0, 0);
        for minimum in [0.01_f32, 0.2, 0.9, 1.7] {
            let error = |t: f32| (t - minimum) * (t - minimum) + 3.0;
            let (best, evaluations) = bench::run::<Bracketed<Brent>>(&bench::line(error), error);
            assert!((best.at - minimum).abs() <= 0.01 * minimum + 1e-4, "{best:?} {minimum}");
            brents += evaluations;
            goldens += bench::run::<Bracketed<GoldenSection>>(&bench::line(error), error).1;
        }
        assert!(brents < goldens, "{brents} {goldens}");
    }

    #[test]
    fn on_cusps_flats_and_cliffs_it_needs_no_more_evaluations_than_golden_sections_do() {
        let errors: [fn(f32) -> f32; 6] = [
            |t| libm::sqrtf(libm::fabsf(t - 0.7)),
            |t| libm::powf(t - 0.7, 4.0),
            |t| libm::expf(8.0 * t) - 60.0 * t,
            |t| 1.0 / (0.01 + t) + 4.0 * t,
            |t| -1.0 / (1.0 + 400.0 * (t - 0.7) * (t - 0.7)),
            |t| if t < 1.5 { 2.0 - t } else { 0.5 + 1000.0 * (t - 1.5) },
        ];
        for (index, error) in errors.into_iter().enumerate() {
            let line = bench::line(error);
            let (brent, few) = bench::run::<Bracketed<Brent>>(&line, error);
            let (golden, many) = bench::run::<Bracketed<GoldenSection>>(&line, error);
            assert!(few <= many, "{index}: {few} {many}");
            assert!((brent.at - golden.at).abs() < TOLERANCE * golden.at, "{index}: {brent:?} {golden:?}");
        }
    }

    #[test]
    fn kinks_and_missing_numbers_do_not_keep_it_from_the_minimum() {
        for minimum in [0.05_f32, 0.33, 1.1] {
            let error = |t: f32| if t > 1.3 * minimum { f32::INFINITY } else { libm::fabsf(t - minimum) };
            let (best, evaluations) = bench::run::<Bracketed<Brent>>(&bench::line(error), error);
            assert!((best.at - minimum).abs() <= TOLERANCE * minimum + 2e-4, "{best:?} {minimum}");
            assert!(evaluations < 30);
        }
    }
}
