//! What all experiments have in common: under which conditions missions are carried out, and how an experiment is
//! carried out, kept and recorded.

use super::grid::Grid;
use super::jobs::{self, Work};
use super::record::{Record, write_csv};
use crate::method::MethodOptions;
use crate::mission::{MissionOptions, Reality};
use crate::scenario::Scenario;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;
use tactus_common::pose::{Interval, PlanarPose};

/// Under which conditions missions are carried out, and how many at a time.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// The scene.
    pub scenario: Scenario,
    /// How reality differs from the model.
    pub reality: Reality,
    /// Seed of the first mission, start or problem; number i uses `seed + i`.
    pub seed: u64,
    /// Most touches of a mission.
    pub trials_max: u8,
    /// Threads; 0 = one per processor. No result depends on it.
    pub jobs: usize,
    /// No progress line.
    pub quiet: bool,
}

impl Conditions {
    /// The seed of number `index`.
    pub fn seed(&self, index: usize) -> u64 {
        self.seed.wrapping_add(index as u64)
    }

    /// The mission of number `index`, the object truly at `truth` and believed in `guess +- interval`.
    pub fn mission(
        &self,
        index: usize,
        truth: PlanarPose,
        guess: PlanarPose,
        interval: Interval,
        method: MethodOptions,
    ) -> MissionOptions {
        MissionOptions {
            scenario: self.scenario.clone(),
            seed: self.seed(index),
            truth,
            guess,
            interval,
            trials_max: self.trials_max,
            reality: self.reality,
            method,
        }
    }
}

/// An experiment under way.
pub struct Experiment<'a> {
    kind: &'static str,
    conditions: &'a Conditions,
    settings: Value,
    grid: Option<&'a Grid>,
    csv: Option<&'a Path>,
    started: Instant,
}

impl<'a> Experiment<'a> {
    /// An experiment of this kind, with the settings of its own beside the conditions; its results go to `csv`.
    pub fn new(
        kind: &'static str,
        conditions: &'a Conditions,
        mut settings: Value,
        grid: Option<&'a Grid>,
        csv: Option<&'a Path>,
    ) -> Self {
        settings["noise"] = json!(conditions.reality == Reality::Mismatched);
        settings["seed"] = json!(conditions.seed);
        settings["trials_max"] = json!(conditions.trials_max);
        Self { kind, conditions, settings, grid, csv, started: Instant::now() }
    }

    /// Carries out its parts `0..count`, called `unit` in the progress line; their results in that order.
    ///
    /// # Errors
    /// As [`jobs::run`].
    pub fn carry_out<T: Serialize + DeserializeOwned + Send>(
        &self,
        unit: &'static str,
        count: usize,
        part: impl Fn(usize) -> anyhow::Result<T> + Sync,
    ) -> anyhow::Result<Vec<T>> {
        let Conditions { jobs: threads, quiet, .. } = *self.conditions;
        let identity = self.identity();
        let work = Work { unit, threads, quiet, settings: &identity, results: self.csv };
        jobs::run(&work, count, part)
    }

    /// All that its results depend on.
    fn identity(&self) -> Value {
        let scene = &self.conditions.scenario;
        json!({ "experiment": self.kind, "settings": self.settings, "grid": self.grid, "scene": scene })
    }

    /// Writes its table, if that was asked for; an interruption from now on finds it whole.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep<'r, R: Serialize + 'r>(&self, rows: impl IntoIterator<Item = &'r R>) -> anyhow::Result<()> {
        let Some(csv) = self.csv else { return Ok(()) };
        write_csv(csv, rows)?;
        jobs::forget(csv)
    }

    /// What goes beside its table.
    pub fn record(self, title: String) -> Record {
        let record = Record::new(self.kind, title, self.settings, self.started.elapsed().as_secs_f64());
        let Some(grid) = self.grid else { return record };
        let truth = self.conditions.scenario.true_pose();
        record.with("truth", json!({ "x": truth.x_m, "y": truth.y_m, "phi": truth.phi_rad })).with("grid", grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conditions() -> Conditions {
        Conditions {
            scenario: Scenario::thesis_box(),
            reality: Reality::Mismatched,
            seed: 1,
            trials_max: 4,
            jobs: 1,
            quiet: true,
        }
    }

    fn identity(conditions: &Conditions) -> Value {
        Experiment::new("trials", conditions, json!({ "method": "ours" }), None, None).identity()
    }

    #[test]
    fn results_belong_together_if_all_is_alike_that_they_depend_on_and_not_otherwise() {
        let here = identity(&conditions());
        let changes: [fn(&mut Conditions); 5] = [
            |c| c.scenario.object.mass_kg = 1.0,
            |c| c.scenario.object.true_pose[0] = 0.1,
            |c| c.reality = Reality::Nominal,
            |c| c.seed = 2,
            |c| c.trials_max = 3,
        ];
        for change in changes {
            let mut other = conditions();
            change(&mut other);
            assert_ne!(identity(&other), here, "{other:?}");
        }
        assert_eq!(identity(&Conditions { jobs: 8, quiet: false, ..conditions() }), here);
        let conditions = conditions();
        let other_method = Experiment::new("trials", &conditions, json!({ "method": "published" }), None, None);
        assert_ne!(other_method.identity(), here);
    }
}
