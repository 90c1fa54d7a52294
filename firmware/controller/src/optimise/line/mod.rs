//! Searches along a line: where along a direction the error is least, or just less.
//!
//! Each asks for a distance along the line and is told the error there; whoever drives it keeps the best point. None
//! asks beyond the end of the line or, but for its first point, below the shortest distance that matters.

pub mod backtracking;
pub mod bracketed;
pub mod bracketing;
pub mod brent;
pub mod golden_section;
pub mod shrinking_step;

pub use backtracking::Backtracking;
pub use bracketed::{Bracketed, Refinement};
pub use bracketing::{Bracket, Bracketing};
pub use brent::Brent;
pub use golden_section::GoldenSection;
pub use shrinking_step::ShrinkingStep;

/// The fraction of the golden section, `(3 - sqrt 5) / 2` (Nikandrova 2011, eq. 18).
pub const GOLDEN: f32 = 0.381_966;
/// A bracket this narrow beside its distance from the start is narrow enough: the next direction gains more.
pub const TOLERANCE: f32 = 0.05;
/// Most evaluations that narrow one bracket: golden sections make it 1e6 times narrower.
pub const REFINEMENTS_MAX: u8 = 30;

/// A line as its search sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The error at its start.
    pub error: f32,
    /// The error's slope at its start, negative.
    pub slope: f32,
    /// The distance to try first.
    pub first: f32,
    /// The distance to the bound.
    pub longest: f32,
    /// The distance below which nothing matters.
    pub shortest: f32,
    /// `true` if a distance of 1 is where the direction's own model of the error has its minimum.
    pub is_whole_step: bool,
}

/// A point on a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probe {
    /// The distance from the start.
    pub at: f32,
    /// The error there.
    pub error: f32,
}

/// A search along a line.
pub trait LineSearch {
    /// A search of `line`.
    fn new(line: &Line) -> Self;
    /// The distance to be evaluated next.
    fn ask(&self) -> f32;
    /// The error there; `true` if the search has ended.
    fn tell(&mut self, error: f32) -> bool;
    /// The first distance to try where the last line led `last` far.
    fn first(last: f32) -> f32 {
        last
    }
}

#[cfg(test)]
pub(crate) mod bench {
    use super::*;

    /// Searches `error` from 0 and gives the best point and the count of evaluations.
    pub fn run<L: LineSearch>(line: &Line, error: impl Fn(f32) -> f32) -> (Probe, usize) {
        let mut search = L::new(line);
        let mut best = Probe { at: 0.0, error: line.error };
        for count in 1..=100 {
            let at = search.ask();
            assert_eq!(at, search.ask());
            assert!(at > 0.0 && at <= line.longest, "{at} on {line:?}");
            if error(at) < best.error {
                best = Probe { at, error: error(at) };
            }
            if search.tell(error(at)) {
                return (best, count);
            }
        }
        panic!("no end");
    }

    /// A line of length 2 with the error `error`, first step 0.1.
    pub fn line(error: impl Fn(f32) -> f32) -> Line {
        let slope = (error(1e-3) - error(0.0)) / 1e-3;
        Line { error: error(0.0), slope, first: 0.1, longest: 2.0, shortest: 1e-4, is_whole_step: false }
    }
}
