//! Regions of convergence: from each start of a grid, does the search find the object? (Nikandrova 2011, fig. 26.)

use super::capture::{Captured, CapturedUpdate, Task, carry_out};
use super::conduct::Experiment;
use super::grid::GridOptions;
use super::method::Formulation;
use super::record::{Record, quantile};
use super::replan::Replan;
use super::search::search;
use crate::mental::MentalModel;
use crate::method::MethodOptions;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::cell::Cell;
use std::fmt;
use std::path::Path;
use std::time::Duration;
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;
use tactus_controller::belief::Belief;
use tactus_controller::error::Evaluation;
use tactus_controller::optimise::Bounds;

/// Chi-squared per degree of freedom up to which a belief explains its evidence.
const CHI_SQUARED_MAX: f32 = 2.0;
/// Distance at which a turn counts as a shift where directions are compared, metres per radian.
const LEVER_M: f32 = 0.1;

/// What became of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The final error is below the threshold.
    Converged,
    /// Not so, but the search moved towards the truth.
    Direction,
    /// Not even that.
    Failed,
}

impl Class {
    /// All, best first.
    pub const ALL: [Self; 3] = [Self::Converged, Self::Direction, Self::Failed];

    /// The name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Direction => "direction",
            Self::Failed => "failed",
        }
    }
}

/// A start's line in the CSV.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    x: f32,
    y: f32,
    phi: f32,
    class: Class,
    final_error: Option<f32>,
    location_error_m: f32,
    yaw_error_rad: f32,
    evaluations: u32,
    time_s: f64,
    stop_reason: String,
}

/// A start's line and what is not in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Outcome {
    row: Row,
    /// Wall time of making the evidence, seconds.
    evidence_s: f64,
    /// Touches made, or trials of the held hand.
    trials: u32,
}

/// What came of all starts.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    starts: usize,
    converged: usize,
    direction: usize,
    failed: usize,
    location_error_median_m: f32,
    location_error_p90_m: f32,
    location_error_max_m: f32,
    yaw_error_max_rad: f32,
    evaluations_mean: f64,
    trials_mean: f64,
    optimiser_time_s: f64,
    optimiser_time_median_s: f32,
    evidence_time_s: f64,
}

impl Statistics {
    fn of(outcomes: &[Outcome]) -> Self {
        let count = |class| outcomes.iter().filter(|o| o.row.class == class).count();
        let n = outcomes.len() as f64;
        let location = |p| quantile(outcomes.iter().map(|o| o.row.location_error_m), p);
        Self {
            starts: outcomes.len(),
            converged: count(Class::Converged),
            direction: count(Class::Direction),
            failed: count(Class::Failed),
            location_error_median_m: location(0.5),
            location_error_p90_m: location(0.9),
            location_error_max_m: location(1.0),
            yaw_error_max_rad: quantile(outcomes.iter().map(|o| o.row.yaw_error_rad), 1.0),
            evaluations_mean: outcomes.iter().map(|o| f64::from(o.row.evaluations)).sum::<f64>() / n,
            trials_mean: outcomes.iter().map(|o| f64::from(o.trials)).sum::<f64>() / n,
            optimiser_time_s: outcomes.iter().map(|o| o.row.time_s).sum(),
            optimiser_time_median_s: quantile(outcomes.iter().map(|o| o.row.time_s as f32), 0.5),
            evidence_time_s: outcomes.iter().map(|o| o.evidence_s).sum(),
        }
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} starts: {} converged, {} in the right direction, {} failed; location error median {:.2} mm, 90 % {:.2} mm, \
             largest {:.2} mm; {:.1} evaluations and {:.1} trials each; optimiser {:.2} s in all ({:.2} ms in the median), \
             evidence {:.0} s",
            self.starts,
            self.converged,
            self.direction,
            self.failed,
            self.location_error_median_m * 1e3,
            self.location_error_p90_m * 1e3,
            self.location_error_max_m * 1e3,
            self.evaluations_mean,
            self.trials_mean,
            self.optimiser_time_s,
            self.optimiser_time_median_s * 1e3,
            self.evidence_time_s,
        )
    }
}

/// Starts the search from every pose of the grid.
///
/// # Errors
/// A file cannot be written, or the scene cannot be simulated.
pub fn run(options: &GridOptions, csv: Option<&Path>) -> anyhow::Result<(Statistics, Record)> {
    let mut settings = options.method.settings();
    settings["dof"] = json!(options.interval().dof());
    let experiment = Experiment::new("converge", &options.conditions, settings, Some(&options.grid), csv);
    let count = options.grid.count();
    let outcomes = match options.method.formulation {
        Formulation::Replan => {
            let replan = options.replan()?;
            experiment.carry_out("starts", count, |i| Ok(search_replan(options, &replan, &options.grid.pose(i))))?
        }
        Formulation::Fixed => {
            let mental = options.conditions.scenario.mental_model()?;
            experiment.carry_out("starts", count, |i| search_fixed(options, i, &mental))?
        }
    };
    experiment.keep(outcomes.iter().map(|o| &o.row))?;
    let statistics = Statistics::of(&outcomes);
    let title = format!(
        "Regions of convergence: {} error, {}, {}, {} unknown, {} reality",
        options.method.config.error.name(),
        options.method.config.optimiser.name(),
        options.method.formulation.name(),
        options.interval().dof(),
        options.conditions.reality.name()
    );
    let record = experiment.record(title).with_statistics(&statistics);
    Ok((statistics, record))
}

fn search_replan(options: &GridOptions, replan: &Replan, start: &PlanarPose) -> Outcome {
    let truth = options.truth();
    let bounds = Bounds::new(start, &options.interval());
    let (trial, trials) = (Cell::new(Duration::ZERO), Cell::new(0));
    let found =
        search(options.method.config.optimiser, start, &bounds, &options.method.config.search_options(1), |pose| {
            let replanned = replan.evaluate(pose);
            trial.set(trial.get() + replanned.trial);
            trials.set(trials.get() + u32::from(!replanned.trial.is_zero()));
            // A pose without an error is no end of a search; why it has none is shown by the surface.
            Evaluation { error: replanned.error.unwrap_or(f32::INFINITY), slope: None }
        });
    let evidence_s = trial.get().as_secs_f64();
    let converged = found.error < options.method.config.goal_error;
    let row = Row {
        final_error: found.error.is_finite().then_some(found.error),
        evaluations: found.evaluations,
        time_s: found.time_s - evidence_s,
        stop_reason: found.reason.name().to_owned(),
        ..row(start, &found.pose, &truth, &options.conditions.scenario.shape(), converged)
    };
    Outcome { row, evidence_s, trials: trials.get() }
}

fn search_fixed(options: &GridOptions, index: usize, mental: &MentalModel) -> anyhow::Result<Outcome> {
    let start = options.grid.pose(index);
    let truth = options.truth();
    let method = MethodOptions::with_ideal_sensors();
    let mission = options.conditions.mission(index, truth, start, options.interval(), method);
    let captured = carry_out(&mission, Task::Locate)?;
    Ok(match captured.last() {
        None => untouched(&start, &captured, &options.conditions.scenario.shape(), &truth),
        Some(last) if options.method.config.is_ours() => by_default(options, &start, &captured, last, mental),
        Some(last) => by_another(options, &start, &captured, last, mental),
    })
}

/// Nothing was felt from there: the belief is the guess.
fn untouched(start: &PlanarPose, captured: &Captured, shape: &ObjectShape, truth: &PlanarPose) -> Outcome {
    let row = Row { stop_reason: captured.report.outcome_text(), ..row(start, start, truth, shape, false) };
    Outcome { row, evidence_s: captured.report.wall_time_s, trials: captured.report.trials }
}

/// The controller's own updates, one after each touch, as in the mission.
fn by_default(
    options: &GridOptions,
    start: &PlanarPose,
    captured: &Captured,
    last: &CapturedUpdate,
    mental: &MentalModel,
) -> Outcome {
    let (mut time, mut evaluations, mut belief) = (Duration::ZERO, 0, Belief::default());
    for update in &captured.updates {
        let again = update.repeat(&options.method.config, mental);
        time += again.time;
        evaluations += u32::from(again.stats.evaluations);
        belief = again.belief;
    }
    let (residuals, chi_squared) = (belief.residuals(), belief.reduced_chi_squared());
    let stop_reason = if last.confident { "confident".to_owned() } else { captured.report.outcome_text() };
    let converged = residuals.contacts > 0 && chi_squared <= CHI_SQUARED_MAX;
    let row = Row {
        final_error: Some(chi_squared),
        evaluations,
        time_s: time.as_secs_f64(),
        stop_reason,
        ..row(start, &belief.pose(), &last.truth, &last.prior.shape, converged)
    };
    Outcome { row, evidence_s: captured.report.wall_time_s, trials: last.touches }
}

/// Another method, on all evidence of the mission at once.
fn by_another(
    options: &GridOptions,
    start: &PlanarPose,
    captured: &Captured,
    last: &CapturedUpdate,
    mental: &MentalModel,
) -> Outcome {
    let found = last.afresh(&options.method.config, mental);
    let (final_error, limit) = match options.method.config.published() {
        Some(_) => (found.stats.error / last.felt.len().max(1) as f32, options.method.config.goal_error),
        None => (found.belief.reduced_chi_squared(), CHI_SQUARED_MAX),
    };
    let row = Row {
        final_error: final_error.is_finite().then_some(final_error),
        evaluations: u32::from(found.stats.evaluations),
        time_s: found.time.as_secs_f64(),
        stop_reason: found.stats.stop.map_or_else(String::new, |reason| reason.name().to_owned()),
        ..row(start, &found.belief.pose(), &last.truth, &last.prior.shape, final_error < limit)
    };
    Outcome { row, evidence_s: captured.report.wall_time_s, trials: last.touches }
}

/// A row of a search that ended at `end`; what it cost is left open.
fn row(start: &PlanarPose, end: &PlanarPose, truth: &PlanarPose, shape: &ObjectShape, converged: bool) -> Row {
    let symmetry_rad = shape.yaw_symmetry_rad();
    let from_start = |pose: &PlanarPose| {
        [pose.x_m - start.x_m, pose.y_m - start.y_m, LEVER_M * pose.turn_from_rad(start, symmetry_rad)]
    };
    let towards: f32 = from_start(end).iter().zip(from_start(truth)).map(|(a, b)| a * b).sum();
    Row {
        x: start.x_m,
        y: start.y_m,
        phi: start.phi_rad,
        class: match (converged, towards > 0.0) {
            (true, _) => Class::Converged,
            (false, true) => Class::Direction,
            (false, false) => Class::Failed,
        },
        final_error: None,
        location_error_m: end.distance_m(truth),
        yaw_error_rad: end.turn_from_rad(truth, symmetry_rad).abs(),
        evaluations: 0,
        time_s: 0.0,
        stop_reason: String::new(),
    }
}
