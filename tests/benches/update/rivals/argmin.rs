//! `argmin`: knows no bounds; see [`super::counted`] for what it finds outside.

use super::counted::Counted;
use super::{contender, simplex};
use crate::Contender;
use argmin::core::{CostFunction, Error, Executor, Gradient};
use argmin::solver::gradientdescent::SteepestDescent;
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::neldermead::NelderMead;
use argmin::solver::quasinewton::{BFGS, LBFGS};

const ORIGIN: &str = "argmin";
const DOWNHILL: &str = "without bounds (outside: the nearest pose within, plus a parabola), downhill from the guess, line search by More and Thuente";

/// Steps that the limited-memory method remembers: as many as there are unknowns.
const MEMORY: usize = 3;

struct Objective<'a, 'b>(&'a Counted<'b>);

impl CostFunction for Objective<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, u: &Self::Param) -> Result<f64, Error> {
        Ok(self.0.at(u)?.error)
    }
}

impl Gradient for Objective<'_, '_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, u: &Self::Param) -> Result<Vec<f64>, Error> {
        Ok(self.0.at(u)?.gradient.to_vec())
    }
}

/// Those that apply.
pub fn all() -> Vec<Contender> {
    vec![
        contender(ORIGIN, "SteepestDescent", DOWNHILL, |counted, budget| {
            let solver = SteepestDescent::new(MoreThuenteLineSearch::new());
            let executor = Executor::new(Objective(counted), solver).timer(false);
            let _ = executor.configure(|state| state.param(vec![0.0; 3]).max_iters(budget)).run();
        }),
        contender(ORIGIN, "BFGS", DOWNHILL, |counted, budget| {
            let identity = vec![vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0], vec![0.0, 0.0, 1.0]];
            let solver = BFGS::new(MoreThuenteLineSearch::new());
            let executor = Executor::new(Objective(counted), solver).timer(false);
            let start = |state: argmin::core::IterState<_, _, _, _, _, _>| {
                state.param(vec![0.0; 3]).inv_hessian(identity).max_iters(budget)
            };
            let _ = executor.configure(start).run();
        }),
        contender(ORIGIN, "L-BFGS", DOWNHILL, |counted, budget| {
            let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
            let executor = Executor::new(Objective(counted), solver).timer(false);
            let _ = executor.configure(|state| state.param(vec![0.0; 3]).max_iters(budget)).run();
        }),
        contender(
            ORIGIN,
            "NelderMead",
            "without bounds (outside: the nearest pose within, plus a parabola), no slope",
            |counted, budget| {
                let executor = Executor::new(Objective(counted), NelderMead::new(simplex())).timer(false);
                let _ = executor.configure(|state| state.max_iters(budget)).run();
            },
        ),
    ]
}
