//! Steepest descent: down the gradient, `d = -g` (Cauchy 1847; Nikandrova 2011, section on steepest descent).
//!
//! The published method of the project's reference is the one with bracketing and golden sections.

use super::descent::{Descent, Direction, Heading, Slope};
use super::line::{Bracketed, Brent, GoldenSection, ShrinkingStep};
use super::search::Search;

/// The steepest direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steepest;

impl Direction for Steepest {
    fn new(_free: usize) -> Self {
        Self
    }

    fn choose(&mut self, slope: &Slope) -> Heading {
        Heading { direction: -slope.gradient, is_whole_step: false }
    }
}

/// Steepest descent with bracketing and golden sections.
pub type SteepestDescentGolden = Search<Descent<Steepest, Bracketed<GoldenSection>>>;
/// Steepest descent with bracketing and Brent's line search.
pub type SteepestDescentBrent = Search<Descent<Steepest, Bracketed<Brent>>>;
/// Steepest descent with a simple step that is shrunk until the error falls.
pub type SteepestDescentSimple = Search<Descent<Steepest, ShrinkingStep>>;
