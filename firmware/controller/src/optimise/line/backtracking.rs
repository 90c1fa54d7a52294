//! Backtracking: the whole step first, then shorter ones, until the error falls as much as its slope lets expect.
//!
//! Sufficient decrease by Armijo (1966); each shorter step is the minimum of the parabola through the error and slope
//! at the start and the error at the last step, within a tenth and a half of that step (Dennis & Schnabel 1983,
//! algorithm A6.3.1, with parabolas throughout).

use super::{Line, LineSearch};

/// Part of the decrease foretold by the slope that is enough.
const ENOUGH: f32 = 1e-4;
/// Bounds of the next step beside the last.
const LEAST: f32 = 0.1;
const MOST: f32 = 0.5;

/// Backtracking. 20 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Backtracking {
    line: Line,
    trial: f32,
}

impl LineSearch for Backtracking {
    fn new(line: &Line) -> Self {
        Self { line: *line, trial: line.first.min(line.longest) }
    }

    fn ask(&self) -> f32 {
        self.trial
    }

    fn tell(&mut self, error: f32) -> bool {
        let Line { error: start, slope, shortest, .. } = self.line;
        let t = self.trial;
        if error <= start + ENOUGH * slope * t && error < start {
            return true;
        }
        let parabola = -slope * t * t / (2.0 * (error - start - slope * t));
        let next = if parabola.is_finite() { parabola } else { 0.0 };
        self.trial = next.max(LEAST * t).min(MOST * t);
        self.trial < shortest
    }

    fn first(_last: f32) -> f32 {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench;
    use super::*;

    #[test]
    fn a_whole_step_that_falls_enough_is_taken_at_once() {
        let error = |t: f32| (t - 1.0) * (t - 1.0);
        let line = Line { first: 1.0, ..bench::line(error) };
        assert_eq!(bench::run::<Backtracking>(&line, error).1, 1);
    }

    #[test]
    fn a_step_too_long_is_shortened_to_the_parabolas_minimum() {
        let error = |t: f32| (t - 0.3) * (t - 0.3);
        let line = Line { first: 1.0, slope: -0.6, ..bench::line(error) };
        let (best, evaluations) = bench::run::<Backtracking>(&line, error);
        assert!(evaluations == 2 && (best.at - 0.3).abs() < 1e-5, "{best:?} {evaluations}");
    }

    #[test]
    fn cliffs_are_backed_away_from_and_a_wrong_slope_ends() {
        let cliff = |t: f32| if t > 0.2 { f32::NAN } else { 1.0 - t };
        let line = Line { first: 1.0, ..bench::line(cliff) };
        let (best, _) = bench::run::<Backtracking>(&line, cliff);
        assert!((0.01..=0.2).contains(&best.at), "{best:?}");
        let line = Line { first: 1.0, slope: -1.0, ..bench::line(|t| t) };
        let (best, evaluations) = bench::run::<Backtracking>(&line, |t| t);
        assert!(best.at == 0.0 && evaluations < 20, "{evaluations}");
    }
}
