//! Golden section: a bracket that each evaluation makes 0.618 times as wide.
//!
//! Kiefer (1953); the fraction is `(3 - sqrt 5) / 2` (Nikandrova 2011, eq. 18). Makes no use of the error's values but
//! their order, and hence does not mind steps and kinks.

use super::{Bracket, GOLDEN, Probe, REFINEMENTS_MAX, Refinement, TOLERANCE};

/// A golden section search. About 40 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct GoldenSection {
    bracket: Bracket,
    trial: f32,
    shortest: f32,
    left: u8,
}

impl GoldenSection {
    /// A point in the wider part of the bracket, by the golden fraction away from the middle.
    fn next_trial(&self) -> f32 {
        let Bracket { low, middle, high } = self.bracket;
        let (below, above) = (middle.at - low.at, high.at - middle.at);
        if above > below { middle.at + GOLDEN * above } else { middle.at - GOLDEN * below }
    }

    fn is_narrow(&self) -> bool {
        let Bracket { low, middle, high } = self.bracket;
        high.at - low.at <= (TOLERANCE * middle.at).max(self.shortest) || self.left == 0
    }
}

impl Refinement for GoldenSection {
    fn new(bracket: &Bracket, shortest: f32) -> Self {
        let mut search = Self { bracket: *bracket, trial: 0.0, shortest, left: REFINEMENTS_MAX };
        search.trial = search.next_trial();
        search
    }

    fn ask(&self) -> f32 {
        self.trial
    }

    fn tell(&mut self, error: f32) -> bool {
        let trial = Probe { at: self.trial, error };
        let Bracket { low, middle, high } = self.bracket;
        let is_above = trial.at > middle.at;
        self.bracket = match (error < middle.error, is_above) {
            (true, true) => Bracket { low: middle, middle: trial, high },
            (true, false) => Bracket { low, middle: trial, high: middle },
            (false, true) => Bracket { low, middle, high: trial },
            (false, false) => Bracket { low: trial, middle, high },
        };
        self.left = self.left.saturating_sub(1);
        self.trial = self.next_trial();
        self.is_narrow()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Bracketed, bench};
    use super::*;

    #[test]
    fn the_minimum_is_found_to_the_tolerance_on_smooth_and_stepped_errors() {
        for minimum in [0.01_f32, 0.2, 0.9, 1.7] {
            for step in [0.0, 1e-3] {
                let error = |t: f32| {
                    let t = if step > 0.0 { libm::floorf(t / step) * step } else { t };
                    libm::fabsf(t - minimum)
                };
                let (best, evaluations) = bench::run::<Bracketed<GoldenSection>>(&bench::line(error), error);
                let off = (best.at - minimum).abs();
                assert!(
                    off <= TOLERANCE * minimum + 2.0 * step && evaluations <= 16,
                    "{best:?} {minimum} {evaluations}"
                );
            }
        }
    }

    #[test]
    fn every_evaluation_narrows_the_bracket_by_the_golden_factor() {
        let probe = |at: f32| Probe { at, error: (at - 0.8) * (at - 0.8) };
        let bracket = Bracket { low: probe(0.0), middle: probe(GOLDEN), high: probe(1.0) };
        let mut search = GoldenSection::new(&bracket, 1e-5);
        let mut width = 1.0;
        for _ in 0..5 {
            search.tell(probe(search.ask()).error);
            let now = search.bracket.high.at - search.bracket.low.at;
            assert!((now / width - 0.618).abs() < 1e-3, "{now} {width}");
            width = now;
        }
    }
}
