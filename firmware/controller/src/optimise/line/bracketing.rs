//! Bracketing: three points of which the middle one is the lowest.
//!
//! Downhill by steps that grow by a constant factor until the error rises again (Nikandrova 2011, section on line
//! search; Press et al. 2007, section 10.1, without its parabolas). Where the first step already leads uphill, the
//! minimum lies before it: the step shrinks instead. Factor and shrinking are those of the golden section, so that the
//! middle point is where a golden section wants it.

use super::{GOLDEN, Line, Probe};

/// Each step is longer than the one before by this: 1.618.
const GROWTH: f32 = (1.0 - GOLDEN) / GOLDEN;

/// Three points in order, `middle` lower than `low` and not higher than `high`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bracket {
    /// The nearest.
    pub low: Probe,
    /// The lowest.
    pub middle: Probe,
    /// The farthest.
    pub high: Probe,
}

/// How bracketing went on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Not done yet.
    Going,
    /// A bracket.
    Found(Bracket),
    /// The error falls up to the end of the line.
    ToTheEnd,
    /// The error falls nowhere, down to the shortest step.
    Nowhere,
}

/// The search for a bracket. About 40 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bracketing {
    low: Probe,
    /// The lowest so far, once any is lower than the start.
    middle: Option<Probe>,
    trial: f32,
    longest: f32,
    shortest: f32,
}

impl Bracketing {
    /// A search along `line`.
    pub fn new(line: &Line) -> Self {
        let low = Probe { at: 0.0, error: line.error };
        Self { low, middle: None, trial: line.first.min(line.longest), longest: line.longest, shortest: line.shortest }
    }

    /// The distance to be evaluated next.
    pub fn ask(&self) -> f32 {
        self.trial
    }

    /// The error there.
    pub fn tell(&mut self, error: f32) -> Outcome {
        let trial = Probe { at: self.trial, error };
        match self.middle {
            None if error < self.low.error => {
                self.middle = Some(trial);
                self.grow(self.low.at, &trial)
            }
            None => {
                let high = trial;
                self.trial *= GOLDEN;
                if self.trial < self.shortest { Outcome::Nowhere } else { self.shrink(&high) }
            }
            Some(middle) if self.is_shrinking(&middle) => {
                // `middle` is the uphill end; the trial lies before it.
                if error < self.low.error {
                    return Outcome::Found(Bracket { low: self.low, middle: trial, high: middle });
                }
                self.trial *= GOLDEN;
                if self.trial < self.shortest { Outcome::Nowhere } else { self.shrink(&trial) }
            }
            Some(middle) if error < middle.error => {
                self.low = middle;
                self.middle = Some(trial);
                self.grow(middle.at, &trial)
            }
            Some(middle) => Outcome::Found(Bracket { low: self.low, middle, high: trial }),
        }
    }

    fn is_shrinking(&self, middle: &Probe) -> bool {
        self.trial < middle.at
    }

    fn shrink(&mut self, high: &Probe) -> Outcome {
        self.middle = Some(*high);
        Outcome::Going
    }

    fn grow(&mut self, before: f32, last: &Probe) -> Outcome {
        if last.at >= self.longest {
            return Outcome::ToTheEnd;
        }
        self.trial = (last.at + GROWTH * (last.at - before)).min(self.longest);
        Outcome::Going
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench;
    use super::*;

    fn bracket(line: &Line, error: impl Fn(f32) -> f32) -> Outcome {
        let mut search = Bracketing::new(line);
        for _ in 0..60 {
            match search.tell(error(search.ask())) {
                Outcome::Going => {}
                end => return end,
            }
        }
        panic!("no end");
    }

    #[test]
    fn the_middle_is_lower_than_both_ends_and_divides_them_as_gold_does() {
        for minimum in [0.003_f32, 0.02, 0.15, 0.7, 1.5] {
            let error = |t: f32| (t - minimum) * (t - minimum);
            let Outcome::Found(b) = bracket(&bench::line(error), error) else { panic!("no bracket of {minimum}") };
            assert!(b.low.at < b.middle.at && b.middle.at < b.high.at, "{b:?}");
            assert!(b.middle.error < b.low.error && b.middle.error < b.high.error, "{b:?}");
            assert!((b.low.at..=b.high.at).contains(&minimum));
            let fraction = (b.middle.at - b.low.at) / (b.high.at - b.low.at);
            assert!((fraction - GOLDEN).abs() < 1e-3 || b.high.at == 2.0, "{fraction}");
        }
    }

    #[test]
    fn an_error_that_falls_to_the_end_or_nowhere_has_no_bracket() {
        assert_eq!(bracket(&bench::line(|t| -t), |t| -t), Outcome::ToTheEnd);
        assert_eq!(bracket(&bench::line(|t| t), |t| t), Outcome::Nowhere);
        assert_eq!(bracket(&bench::line(|_| 1.0), |_| 1.0), Outcome::Nowhere);
        assert_eq!(bracket(&bench::line(|_| 1.0), |_| f32::INFINITY), Outcome::Nowhere);
    }
}
