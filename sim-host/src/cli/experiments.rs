//! The commands that carry experiments out: `surface`, `converge`, `compare`.

use super::{CommonArgs, is_quiet, scenario, triple, with_dof};
use crate::experiment::compare::{self, CompareOptions};
use crate::experiment::conduct::Conditions;
use crate::experiment::converge;
use crate::experiment::grid::{Axis, Grid, GridOptions};
use crate::experiment::method::{Formulation, Method};
use crate::experiment::record::Record;
use crate::experiment::surface;
use crate::method::{check_damping, error_parser, gradient_parser, optimizer, predictor_parser};
use crate::mission::Reality;
use crate::scenario::Scenario;
use clap::Args;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use tactus_common::message::ROLLOUT_INSTANTS;
use tactus_controller::error::ErrorKind;
use tactus_controller::optimise::{Gradient, Method as Optimiser};
use tactus_controller::predict::PredictorKind;
use tactus_controller::update::UpdateConfig;
use tactus_hil::say;

/// Evaluations of the published method from one start, at most.
const PUBLISHED_EVALUATIONS: u16 = 200;

/// What every experiment takes.
#[derive(Args, Debug)]
struct ExperimentArgs {
    #[command(flatten)]
    common: CommonArgs,
    /// How reality differs from the model: `mismatched` by seed and with noise, or `nominal`.
    #[arg(long, value_enum, default_value_t = Reality::Mismatched)]
    reality: Reality,
    /// Write one line per pose, start or problem; beside it FILE with the ending .json says how it was made. An
    /// interrupted experiment goes on from FILE.partial.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// How many at a time [default: one per processor]; the results do not depend on it.
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

/// A grid of poses and a method; table 3 of the thesis by default.
#[derive(Args, Debug)]
struct GridArgs {
    /// Components that are unknown: 1 = x, 2 = x and y, 3 = x, y and phi; the grid has the true value in the others.
    #[arg(long, value_name = "1|2|3", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=3))]
    dof: u8,
    /// Grid in x, metres.
    #[arg(long, value_name = "MIN,MAX,STEP", default_value = "0.1,0.3,0.01", allow_hyphen_values = true)]
    x: Axis,
    /// Grid in y, metres.
    #[arg(long, value_name = "MIN,MAX,STEP", default_value = "-0.15,-0.04,0.005", allow_hyphen_values = true)]
    y: Axis,
    /// Grid in phi, radians.
    #[arg(long, value_name = "MIN,MAX,STEP", default_value = "-0.7,0.7,0.35", allow_hyphen_values = true)]
    phi: Axis,
    /// Error function: contact, weighted, modified (the published ones) or geometric.
    #[arg(long, value_name = "NAME", default_value = "geometric", value_parser = error_parser())]
    error: ErrorKind,
    /// What foretells the readings of fixed touches for the published errors: kinematic or simulation (replan always
    /// simulates).
    #[arg(long, value_name = "NAME", default_value = "kinematic", value_parser = predictor_parser())]
    predictor: PredictorKind,
    /// What is repeated at each pose [default: replan for the published errors, fixed for the geometric one].
    #[arg(long, value_enum)]
    formulation: Option<Formulation>,
    /// The constant `a` that damps later differences, in instants (errors weighted and modified).
    #[arg(long, value_name = "A", default_value_t = 4.0)]
    damping: f32,
    /// Instants at which contacts are compared (errors contact, weighted and modified).
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u8).range(1..=ROLLOUT_INSTANTS as i64))]
    instants: u8,
    /// Most touches of a mission (formulation fixed).
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u8).range(1..=8))]
    max_trials: u8,
}

/// `tactus surface`.
#[derive(Args, Debug)]
pub(super) struct SurfaceArgs {
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    grid: GridArgs,
}

/// `tactus converge`.
#[derive(Args, Debug)]
pub(super) struct ConvergeArgs {
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    grid: GridArgs,
    /// Optimiser [default: levenberg-marquardt for the geometric error, steepest-descent-golden for the others].
    #[arg(long, value_name = "NAME", value_parser = optimizer)]
    optimizer: Option<Optimiser>,
    /// Where slopes come from: one-sided, two-sided, or analytic where the error has one, two-sided where not.
    #[arg(long, value_name = "NAME", default_value = "analytic", value_parser = gradient_parser())]
    gradient: Gradient,
    /// Most evaluations of one search [default: as many as the method takes; 200 for the published errors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    evaluations: Option<u16>,
}

/// `tactus compare`.
#[derive(Args, Debug)]
pub(super) struct CompareArgs {
    #[command(flatten)]
    experiment: ExperimentArgs,
    /// Problems for each number of unknown components.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// Half widths of the guess's error: the truth lies anywhere in guess +- this.
    #[arg(long, value_name = "DX,DY,DPHI", value_parser = triple, default_value = "0.10,0.10,0.78")]
    offset: [f32; 3],
    /// Numbers of unknown components, with commas between them.
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "1,2,3",
          value_parser = clap::value_parser!(u8).range(1..=3))]
    dof: Vec<u8>,
    /// Errors, with commas between them.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = "geometric,modified,weighted,contact",
          value_parser = error_parser())]
    error: Vec<ErrorKind>,
    /// What foretells the readings for the published errors: kinematic or simulation.
    #[arg(long, value_name = "NAME", default_value = "kinematic", value_parser = predictor_parser())]
    predictor: PredictorKind,
    /// Budgets of evaluations, with commas between them.
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "30,100,300",
          value_parser = clap::value_parser!(u16).range(1..))]
    budget: Vec<u16>,
    /// Most touches of a problem.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=8))]
    max_trials: u8,
}

/// The options of a grid and a method.
fn options(experiment: &ExperimentArgs, args: &GridArgs, search: UpdateConfig) -> anyhow::Result<GridOptions> {
    check_damping(args.damping)?;
    let scenario = scenario(&experiment.common)?;
    let truth = scenario.true_pose();
    let grid = Grid {
        x: args.x,
        y: if args.dof >= 2 { args.y } else { Axis::at(truth.y_m) },
        phi: if args.dof >= 3 { args.phi } else { Axis::at(truth.phi_rad) },
    };
    for index in [0, grid.count() - 1] {
        scenario.check_on_table("grid", &grid.pose(index))?;
    }
    let formulation = args.formulation.unwrap_or(match args.error.published() {
        Some(_) => Formulation::Replan,
        None => Formulation::Fixed,
    });
    let config = UpdateConfig {
        error: args.error,
        predictor: args.predictor,
        damping: args.damping,
        instants: args.instants,
        ..search
    };
    Ok(GridOptions {
        conditions: conditions(experiment, scenario, args.max_trials),
        grid,
        method: Method { formulation, config },
    })
}

/// The conditions of an experiment in a scene.
fn conditions(experiment: &ExperimentArgs, scenario: Scenario, trials_max: u8) -> Conditions {
    Conditions {
        scenario,
        reality: experiment.reality,
        seed: experiment.common.seed,
        trials_max,
        jobs: experiment.jobs.map_or(0, usize::from),
        quiet: is_quiet(&experiment.common),
    }
}

/// Prints and writes what came of an experiment.
fn report(args: &ExperimentArgs, statistics: &impl Display, record: Record, line: &str) -> anyhow::Result<u8> {
    if !is_quiet(&args.common) {
        say::line(statistics)?;
    }
    write(args.csv.as_deref(), args.common.summary.as_deref(), &record.with_command(line))
}

/// Writes the record beside the numbers, and where else it is asked for.
pub(super) fn write(csv: Option<&Path>, summary: Option<&Path>, record: &Record) -> anyhow::Result<u8> {
    if let Some(csv) = csv {
        record.write_beside(csv)?;
    }
    if let Some(path) = summary {
        record.write(path)?;
    }
    Ok(0)
}

pub(super) fn surface(args: &SurfaceArgs, line: &str) -> anyhow::Result<u8> {
    let options = options(&args.experiment, &args.grid, UpdateConfig::default())?;
    let (statistics, record) = surface::run(&options, args.experiment.csv.as_deref())?;
    report(&args.experiment, &statistics, record, line)
}

pub(super) fn converge(args: &ConvergeArgs, line: &str) -> anyhow::Result<u8> {
    let published = args.grid.error.published().is_some();
    let by_default = if published { Optimiser::SteepestDescentGolden } else { Optimiser::LevenbergMarquardt };
    let search = UpdateConfig {
        optimiser: args.optimizer.unwrap_or(by_default),
        gradient: if published && args.gradient == Gradient::Analytic { Gradient::TwoSided } else { args.gradient },
        evaluations_max: args.evaluations.unwrap_or(if published { PUBLISHED_EVALUATIONS } else { 0 }),
        ..UpdateConfig::default()
    };
    let options = options(&args.experiment, &args.grid, search)?;
    let (statistics, record) = converge::run(&options, args.experiment.csv.as_deref())?;
    report(&args.experiment, &statistics, record, line)
}

pub(super) fn compare(args: &CompareArgs, line: &str) -> anyhow::Result<u8> {
    let options = CompareOptions {
        conditions: conditions(&args.experiment, scenario(&args.experiment.common)?, args.max_trials),
        count: args.count,
        offset: with_dof(args.offset, 3)?,
        dofs: args.dof.clone(),
        predictor: args.predictor,
        errors: args.error.clone(),
        budgets: args.budget.clone(),
    };
    let (statistics, record) = compare::run(&options, args.experiment.csv.as_deref())?;
    report(&args.experiment, &statistics, record, line)
}
