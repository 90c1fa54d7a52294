//! Our contenders: the controller's update as it is, and each of its optimisers alone.

use crate::{Contender, Outcome};
use tactus_controller::belief::Belief;
use tactus_controller::error::ErrorFunction;
use tactus_controller::optimise::{AnyOptimiser, Method, SearchOptions, carry_through};
use tactus_controller::update::{Progress, Update, UpdateConfig};
use tactus_controller::work::Work;
use tactus_tests::problems::Problem;

/// Name of the crate in tables.
pub const ORIGIN: &str = "tactus";
/// Name of the controller's own update.
pub const DEFAULT: &str = "default update";

/// The default, then every optimiser of the list.
pub fn all() -> Vec<Contender> {
    let default = Contender {
        origin: ORIGIN,
        name: DEFAULT,
        bytes: Some(size_of::<Update>()),
        note: "the whole update of the belief: several starts, wide and narrow loss, modes and covariance; no budget",
        update: Box::new(|problem, _| default_update(problem)),
    };
    let searches = Method::ALL.map(|method| Contender {
        origin: ORIGIN,
        name: method.name(),
        bytes: method.size(),
        note: "",
        update: Box::new(move |problem, budget| search(method, problem, budget)),
    });
    [default].into_iter().chain(searches).collect()
}

fn default_update(problem: &Problem) -> Outcome {
    let config = UpdateConfig { geometric: Problem::config(), ..UpdateConfig::default() };
    let mut update = Update::new(&problem.prior, &Belief::from_prior(&problem.prior), &config);
    while update.step(&mut Work::unlimited(), &problem.evidence) == Progress::Running {}
    Outcome { pose: update.belief().pose(), evaluations: u32::from(update.stats().evaluations) }
}

fn search(method: Method, problem: &Problem, budget: u16) -> Outcome {
    let error = problem.error();
    let options = SearchOptions { evaluations_max: budget, ..SearchOptions::default() };
    let guess = problem.prior.guess;
    let mut search =
        AnyOptimiser::new(method, &guess, &problem.prior.bounds(), &options).expect("the host has all optimisers");
    let found = carry_through(&mut search, |pose| error.evaluate(pose));
    Outcome { pose: found.map_or(guess, |(found, _)| found.pose), evaluations: u32::from(search.evaluations()) }
}
