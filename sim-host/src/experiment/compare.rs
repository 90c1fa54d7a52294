//! All methods on the same problems: the same stored evidence, the same bounds, the same start, equal budgets.
//!
//! A problem is a mission up to the update that would lead to the grasp: true pose, guess, noise and mismatch by seed;
//! the truth lies anywhere in the interval. Its evidence is felt once, in the simulated reality.

use super::capture::{Task, carry_out};
use super::conduct::{Conditions, Experiment};
use super::method::Formulation;
use super::observability::Observed;
use super::record::{Record, quantile};
use super::trials::truth_of;
use crate::mental::MentalModel;
use crate::method::MethodOptions;
use crate::mission::guess_around;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::fmt;
use std::path::Path;
use tactus_common::pose::Interval;
use tactus_controller::error::ErrorKind;
use tactus_controller::optimise::Method as Optimiser;
use tactus_controller::predict::PredictorKind;
use tactus_controller::update::UpdateConfig;

/// What to compare.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// The conditions of the problems.
    pub conditions: Conditions,
    /// Problems for each number of unknown components.
    pub count: u32,
    /// Half widths of the guess's error, all three components.
    pub offset: Interval,
    /// Numbers of unknown components: 1 = x, 2 = x and y, 3 = all.
    pub dofs: Vec<u8>,
    /// What foretells the readings for the published errors.
    pub predictor: PredictorKind,
    /// The errors.
    pub errors: Vec<ErrorKind>,
    /// Most evaluations.
    pub budgets: Vec<u16>,
}

/// A method's line for one problem.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Row {
    problem: u32,
    dof: u8,
    error: String,
    optimizer: String,
    budget: u16,
    location_error_m: f32,
    yaw_error_rad: f32,
    final_error: Option<f32>,
    evaluations: u32,
    time_s: f64,
    stop_reason: String,
    observability: String,
}

/// A method at a budget, over all problems.
#[derive(Clone, Debug, Serialize)]
struct Line {
    dof: u8,
    error: String,
    optimizer: String,
    budget: u16,
    problems: usize,
    median_m: f32,
    p90_m: f32,
    within_2mm: f64,
    within_10mm: f64,
    evaluations_median: f32,
    time_median_s: f32,
}

/// The table.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    /// Problems for each number of unknown components.
    problems: u32,
    /// Problems whose evidence says where the object stands, by number of unknown components.
    observable: Vec<(u8, usize)>,
    table: Vec<Line>,
}

impl Statistics {
    fn of(options: &CompareOptions, rows: &[Row]) -> Self {
        let mut table = Vec::new();
        let mut observable = Vec::new();
        for dof in &options.dofs {
            let of_dof = || rows.iter().filter(|row| row.dof == *dof);
            let mut seen: Vec<u32> =
                of_dof().filter(|row| row.observability == OBSERVABLE).map(|row| row.problem).collect();
            seen.sort_unstable();
            seen.dedup();
            observable.push((*dof, seen.len()));
            for (error, optimiser, budget) in methods(options) {
                let of_method: Vec<&Row> = of_dof()
                    .filter(|r| r.error == error.name() && r.optimizer == optimiser.name() && r.budget == budget)
                    .collect();
                table.push(Line::of(*dof, &of_method));
            }
        }
        table.retain(|line| line.problems > 0);
        Self { problems: options.count, observable, table }
    }
}

impl Line {
    fn of(dof: u8, rows: &[&Row]) -> Self {
        let n = rows.len() as f64;
        let location = |p| quantile(rows.iter().map(|r| r.location_error_m), p);
        let within = |limit_m| rows.iter().filter(|r| r.location_error_m <= limit_m).count() as f64 / n;
        let first = rows.first();
        Self {
            dof,
            error: first.map_or_else(String::new, |r| r.error.clone()),
            optimizer: first.map_or_else(String::new, |r| r.optimizer.clone()),
            budget: first.map_or(0, |r| r.budget),
            problems: rows.len(),
            median_m: location(0.5),
            p90_m: location(0.9),
            within_2mm: within(2e-3),
            within_10mm: within(10e-3),
            evaluations_median: quantile(rows.iter().map(|r| r.evaluations as f32), 0.5),
            time_median_s: quantile(rows.iter().map(|r| r.time_s as f32), 0.5),
        }
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:>3} {:<10} {:<24} {:>6} {:>9} {:>9} {:>7} {:>7} {:>6} {:>9}",
            "dof", "error", "optimizer", "budget", "median/mm", "90 %/mm", "<2 mm", "<10 mm", "eval.", "time/ms"
        )?;
        for line in &self.table {
            writeln!(
                f,
                "{:>3} {:<10} {:<24} {:>6} {:>9.2} {:>9.2} {:>6.1}% {:>6.1}% {:>6.0} {:>9.3}",
                line.dof,
                line.error,
                line.optimizer,
                line.budget,
                line.median_m * 1e3,
                line.p90_m * 1e3,
                line.within_2mm * 100.0,
                line.within_10mm * 100.0,
                line.evaluations_median,
                line.time_median_s * 1e3,
            )?;
        }
        for (dof, count) in &self.observable {
            writeln!(f, "{dof} unknown: the evidence of {count} of {} problems tells the pose", self.problems)?;
        }
        Ok(())
    }
}

const OBSERVABLE: &str = "observable";

/// All methods, in the order of the table.
fn methods(options: &CompareOptions) -> Vec<(ErrorKind, Optimiser, u16)> {
    let mut all = Vec::new();
    for error in &options.errors {
        for optimiser in Optimiser::ALL {
            all.extend(options.budgets.iter().map(|budget| (*error, optimiser, *budget)));
        }
    }
    all
}

/// Gives every method every problem.
///
/// # Errors
/// A file cannot be written, or the scene cannot be simulated.
pub fn run(options: &CompareOptions, csv: Option<&Path>) -> anyhow::Result<(Statistics, Record)> {
    let settings = json!({
        "errors": options.errors.iter().map(|e| e.name()).collect::<Vec<_>>(),
        "formulation": Formulation::Fixed.name(), "predictor": options.predictor.name(),
        "budgets": options.budgets, "dofs": options.dofs, "count": options.count,
        "offset": options.offset.to_array(),
    });
    let experiment = Experiment::new("compare", &options.conditions, settings, None, csv);
    let mental = options.conditions.scenario.mental_model()?;
    let per_dof = options.count as usize;
    let rows: Vec<Vec<Row>> = experiment.carry_out("problems", per_dof * options.dofs.len(), |i| {
        solve(options, i % per_dof, options.dofs[i / per_dof], &mental)
    })?;
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    experiment.keep(&rows)?;
    let statistics = Statistics::of(options, &rows);
    let title = format!("Comparison: {} problems for each number of unknown components", options.count);
    let record = experiment.record(title).with_statistics(&statistics);
    Ok((statistics, record))
}

fn solve(options: &CompareOptions, problem: usize, dof: u8, mental: &MentalModel) -> anyhow::Result<Vec<Row>> {
    let seed = options.conditions.seed(problem);
    let interval = options.offset.of_first(dof);
    let truth = truth_of(&options.conditions.scenario, seed)?;
    let guess = guess_around(&truth, &interval, seed);
    let mission = options.conditions.mission(problem, truth, guess, interval, MethodOptions::with_ideal_sensors());
    let captured = carry_out(&mission, Task::Locate)?;
    // A mission that touched nothing has no evidence to compare methods on.
    let Some(last) = captured.last() else { return Ok(Vec::new()) };
    let observed = Observed::new(&last.evidence, &last.prior);
    let is_observable = observed.judge(&last.after.pose(), &last.truth).1.is_observable();
    let observability = if is_observable { OBSERVABLE } else { "not observable" };
    let rows = methods(options).into_iter().map(|(error, optimiser, evaluations_max)| {
        let config = UpdateConfig {
            error,
            optimiser,
            evaluations_max,
            predictor: options.predictor,
            // Every search goes on until its budget is spent, or it can find nothing better.
            goal_error: 0.0,
            ..UpdateConfig::default()
        };
        let found = last.afresh(&config, mental);
        let pose = found.belief.pose();
        Row {
            problem: problem as u32,
            dof,
            error: error.name().to_owned(),
            optimizer: optimiser.name().to_owned(),
            budget: evaluations_max,
            location_error_m: pose.distance_m(&last.truth),
            yaw_error_rad: pose.turn_from_rad(&last.truth, last.prior.shape.yaw_symmetry_rad()).abs(),
            final_error: found.stats.error.is_finite().then_some(found.stats.error),
            evaluations: u32::from(found.stats.evaluations),
            time_s: found.time.as_secs_f64(),
            stop_reason: found.stats.stop.map_or_else(String::new, |reason| reason.name().to_owned()),
            observability: observability.to_owned(),
        }
    });
    Ok(rows.collect())
}
