//! A line search of two parts: bracketing, then a refinement of the bracket.

use super::bracketing::{Bracketing, Outcome};
use super::{Bracket, Line, LineSearch};

/// Narrows a bracket.
pub trait Refinement {
    /// A refinement of `bracket` down to the distance `shortest`.
    fn new(bracket: &Bracket, shortest: f32) -> Self;
    /// The distance to be evaluated next.
    fn ask(&self) -> f32;
    /// The error there; `true` if the bracket is narrow enough.
    fn tell(&mut self, error: f32) -> bool;
}

#[derive(Clone, Copy, Debug)]
enum Part<R> {
    Bracketing(Bracketing),
    Refining(R),
}

/// Bracketing, then the refinement `R`. About 80 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Bracketed<R> {
    part: Part<R>,
    shortest: f32,
}

impl<R: Refinement> LineSearch for Bracketed<R> {
    fn new(line: &Line) -> Self {
        Self { part: Part::Bracketing(Bracketing::new(line)), shortest: line.shortest }
    }

    fn ask(&self) -> f32 {
        match &self.part {
            Part::Bracketing(search) => search.ask(),
            Part::Refining(search) => search.ask(),
        }
    }

    fn tell(&mut self, error: f32) -> bool {
        match &mut self.part {
            Part::Bracketing(search) => match search.tell(error) {
                Outcome::Going => false,
                Outcome::Found(bracket) => {
                    self.part = Part::Refining(R::new(&bracket, self.shortest));
                    false
                }
                Outcome::ToTheEnd | Outcome::Nowhere => true,
            },
            Part::Refining(search) => search.tell(error),
        }
    }
}
