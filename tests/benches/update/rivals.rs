//! Optimisers of other crates: one file a crate. Each gets the same box, start and budget, its own defaults otherwise; a
//! step length or simplex that must be given is 0.6 half widths.

mod argmin;
mod basin;
mod cmaes;
mod counted;

use crate::{Contender, Outcome};
use counted::Counted;

/// First step length of methods that must be told one, in half widths of the interval: that of our own evolution strategy.
const STEP: f64 = 0.6;
/// Seed of methods that draw random numbers.
const SEED: u64 = 1;

/// All of them.
pub fn all() -> Vec<Contender> {
    [argmin::all(), basin::all(), cmaes::all()].into_iter().flatten().collect()
}

/// A contender that searches until it is done or the budget is spent; what it says then does not matter, for the best
/// pose it looked at is remembered.
fn contender(
    origin: &'static str,
    name: &'static str,
    note: &'static str,
    search: impl Fn(&Counted<'_>, u64) + 'static,
) -> Contender {
    let update = move |problem: &_, budget| -> Outcome {
        let counted = Counted::new(problem, budget);
        search(&counted, u64::from(budget));
        counted.outcome()
    };
    Contender { origin, name, bytes: None, note, update: Box::new(update) }
}

/// The corners of a simplex about the start.
fn simplex() -> Vec<Vec<f64>> {
    vec![vec![0.0; 3], vec![STEP, 0.0, 0.0], vec![0.0, STEP, 0.0], vec![0.0, 0.0, STEP]]
}
