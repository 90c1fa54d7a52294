//! The simple step: as long as it was, halved until the error falls.
//!
//! Nikandrova (2011), steepest descent with a step that is shrunk until the error falls. A step that was taken is tried
//! twice as long on the next line, as it could never grow again otherwise.

use super::{Line, LineSearch};

/// Each step is this part of the one before.
const SHRINKAGE: f32 = 0.5;

/// The simple step. 12 bytes.
#[derive(Clone, Copy, Debug)]
pub struct ShrinkingStep {
    error: f32,
    trial: f32,
    shortest: f32,
}

impl LineSearch for ShrinkingStep {
    fn new(line: &Line) -> Self {
        Self { error: line.error, trial: line.first.min(line.longest), shortest: line.shortest }
    }

    fn ask(&self) -> f32 {
        self.trial
    }

    fn tell(&mut self, error: f32) -> bool {
        if error < self.error || self.trial * SHRINKAGE < self.shortest {
            return true;
        }
        self.trial *= SHRINKAGE;
        false
    }

    fn first(last: f32) -> f32 {
        last / SHRINKAGE
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench;
    use super::*;

    #[test]
    fn the_first_step_that_falls_is_taken() {
        let error = |t: f32| (t - 0.02) * (t - 0.02);
        let (best, evaluations) = bench::run::<ShrinkingStep>(&bench::line(error), error);
        assert_eq!((best.at, evaluations), (0.025, 3));
    }

    #[test]
    fn where_nothing_falls_it_ends() {
        let (best, evaluations) = bench::run::<ShrinkingStep>(&bench::line(|t| t), |t| t);
        assert_eq!((best.at, evaluations), (0.0, 10));
    }
}
