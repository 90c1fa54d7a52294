//! An error over a grid of poses (Nikandrova 2011, fig. 25).

use super::capture::{Task, carry_out};
use super::conduct::Experiment;
use super::grid::GridOptions;
use super::method::Formulation;
use super::record::Record;
use crate::method::MethodOptions;
use crate::mission::guess_around;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// Outcome of a pose that has an error.
const OK: &str = "ok";

/// A pose's line in the CSV.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Row {
    x: f32,
    y: f32,
    phi: f32,
    error: Option<f32>,
    outcome: String,
}

/// What came of all poses.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    poses: usize,
    /// Poses by outcome.
    outcomes: BTreeMap<String, usize>,
    error_min: f32,
    error_max: f32,
    /// Where the error is least, and how many poses have that least error.
    least_at: [f32; 3],
    least_count: usize,
}

impl Statistics {
    fn of(rows: &[Row]) -> Self {
        let mut outcomes = BTreeMap::new();
        let (mut error_min, mut error_max, mut least_at) = (f32::INFINITY, f32::NEG_INFINITY, [f32::NAN; 3]);
        for row in rows {
            *outcomes.entry(row.outcome.clone()).or_insert(0) += 1;
            let Some(error) = row.error else { continue };
            if error < error_min {
                (error_min, least_at) = (error, [row.x, row.y, row.phi]);
            }
            error_max = error_max.max(error);
        }
        let least_count = rows.iter().filter(|row| row.error == Some(error_min)).count();
        Self { poses: rows.len(), outcomes, error_min, error_max, least_at, least_count }
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, phi] = self.least_at;
        write!(
            f,
            "{} poses: error {:.3} to {:.3}, least at ({x:.3} m, {y:.3} m, {phi:.3} rad) and as small at {} in all",
            self.poses, self.error_min, self.error_max, self.least_count
        )?;
        for (outcome, count) in self.outcomes.iter().filter(|(outcome, _)| *outcome != OK) {
            write!(f, "\n  {count} x {outcome}")?;
        }
        Ok(())
    }
}

/// The error at every pose of the grid: of a trial planned for that pose, or of the touches of one mission.
///
/// # Errors
/// A file cannot be written, the scene cannot be simulated, or the mission touched nothing.
pub fn run(options: &GridOptions, csv: Option<&Path>) -> anyhow::Result<(Statistics, Record)> {
    let mut settings = options.method.settings();
    for name in ["optimizer", "gradient", "evaluations_max", "goal_error"] {
        settings.as_object_mut().and_then(|object| object.remove(name));
    }
    let experiment = Experiment::new("surface", &options.conditions, settings, Some(&options.grid), csv);
    let count = options.grid.count();
    let rows = match options.method.formulation {
        Formulation::Replan => {
            let replan = options.replan()?;
            experiment.carry_out("poses", count, |i| {
                let error = replan.evaluate(&options.grid.pose(i)).error;
                Ok(row(options, i, error.map_err(|reason| reason.to_string())))
            })?
        }
        Formulation::Fixed => {
            let (truth, interval, seed) = (options.truth(), options.interval(), options.conditions.seed);
            let guess = guess_around(&truth, &interval, seed);
            let mission = options.conditions.mission(0, truth, guess, interval, MethodOptions::with_ideal_sensors());
            let captured = carry_out(&mission, Task::Locate)?;
            let last = captured
                .last()
                .ok_or_else(|| anyhow::anyhow!("the mission of seed {seed} touched nothing; expected another seed"))?;
            let mental = options.conditions.scenario.mental_model()?;
            let error = options.method.fixed_error(last, &mental);
            experiment.carry_out("poses", count, |i| Ok(row(options, i, Ok(error(&options.grid.pose(i))))))?
        }
    };
    experiment.keep(&rows)?;
    let statistics = Statistics::of(&rows);
    let title = format!("Error surface: {}, {}", options.method.config.error.name(), options.method.formulation.name());
    let record = experiment.record(title).with_statistics(&statistics);
    Ok((statistics, record))
}

fn row(options: &GridOptions, index: usize, error: Result<f32, String>) -> Row {
    let [x, y, phi] = options.grid.pose(index).to_array();
    let (error, outcome) = match error {
        Ok(error) => (Some(error), OK.to_owned()),
        Err(reason) => (None, reason),
    };
    Row { x, y, phi, error, outcome }
}
