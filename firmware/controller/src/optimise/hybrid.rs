//! Hybrid: steepest descent with golden sections first, Newton-Raphson with backtracking once progress slows
//! (Nikandrova 2011, hybrid method).
//!
//! Slow = a line that took away less than half of the error, or led nowhere: steepest descent reaches the neighbourhood
//! of a minimum, where its zigzag costs more evaluations than second derivatives do. There is no way back.

use super::descent::{Descent, Direction, Heading, Slope};
use super::line::{Backtracking, Bracketed, GoldenSection, Line, LineSearch};
use super::newton::Newton;
use super::search::Search;

/// Progress is slow when this part of the error or more is left after a line.
const SLOW: f32 = 0.5;

/// The steepest direction, then Newton's.
#[derive(Clone, Copy, Debug, Default)]
pub struct SteepestThenNewton {
    is_slow: bool,
}

impl Direction for SteepestThenNewton {
    fn new(_free: usize) -> Self {
        Self { is_slow: false }
    }

    fn wants_curvature(&self) -> bool {
        self.is_slow
    }

    fn choose(&mut self, slope: &Slope) -> Heading {
        if self.is_slow {
            return Newton.choose(slope);
        }
        Heading { direction: -slope.gradient, is_whole_step: false }
    }

    fn restart(&mut self) -> bool {
        let was_fast = !self.is_slow;
        self.is_slow = true;
        was_fast
    }

    fn arrive(&mut self, before: f32, after: f32) {
        self.is_slow |= after >= SLOW * before;
    }
}

/// Backtracking on whole steps, bracketing and golden sections on others.
#[derive(Clone, Copy, Debug)]
pub enum EitherLine {
    /// The line of a direction without a length of its own.
    Golden(Bracketed<GoldenSection>),
    /// The line of a whole step.
    Backtracking(Backtracking),
}

impl LineSearch for EitherLine {
    fn new(line: &Line) -> Self {
        if line.is_whole_step { Self::Backtracking(LineSearch::new(line)) } else { Self::Golden(LineSearch::new(line)) }
    }

    fn ask(&self) -> f32 {
        match self {
            Self::Golden(line) => line.ask(),
            Self::Backtracking(line) => line.ask(),
        }
    }

    fn tell(&mut self, error: f32) -> bool {
        match self {
            Self::Golden(line) => line.tell(error),
            Self::Backtracking(line) => line.tell(error),
        }
    }
}

/// Steepest descent, then Newton-Raphson.
pub type Hybrid = Search<Descent<SteepestThenNewton, EitherLine>>;
