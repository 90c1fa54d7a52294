//! What goes beside the numbers of an experiment: how they were made, and on what.

use crate::report::summary::write_json;
use anyhow::Context;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::Path;

/// An experiment's settings and what came of it: `STEM.json` beside `STEM.csv`.
#[derive(Serialize, Clone, Debug)]
pub struct Record {
    experiment: &'static str,
    title: String,
    command: String,
    settings: Value,
    #[serde(flatten)]
    more: Map<String, Value>,
    statistics: Value,
    machine: Value,
    wall_time_s: f64,
}

impl Record {
    /// The record of an experiment of this kind.
    pub fn new(experiment: &'static str, title: String, settings: Value, wall_time_s: f64) -> Self {
        Self {
            experiment,
            title,
            command: String::new(),
            settings,
            more: Map::new(),
            statistics: Value::Null,
            machine: machine(),
            wall_time_s,
        }
    }

    /// With the command line that makes the experiment again.
    #[must_use]
    pub fn with_command(mut self, line: &str) -> Self {
        line.clone_into(&mut self.command);
        self
    }

    /// With one entry more.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Serialize) -> Self {
        self.more.insert(name.to_owned(), json!(value));
        self
    }

    /// With these statistics.
    #[must_use]
    pub fn with_statistics(mut self, statistics: impl Serialize) -> Self {
        self.statistics = json!(statistics);
        self
    }

    /// With these statistics, which are also entries of their own: the summary of a batch.
    #[must_use]
    pub fn with_summary(mut self, statistics: impl Serialize) -> Self {
        self.statistics = json!(statistics);
        if let Value::Object(entries) = &self.statistics {
            self.more.extend(entries.clone());
        }
        self
    }

    /// Writes it beside the numbers in `csv`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_beside(&self, csv: &Path) -> anyhow::Result<()> {
        write_json(self, &csv.with_extension("json"))
    }

    /// Writes it to a file, or to standard output for `-`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        write_json(self, path)
    }
}

/// What it runs on.
fn machine() -> Value {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let cpu = cpuinfo.lines().find_map(|l| l.strip_prefix("model name")?.split_once(':')).map(|(_, name)| name.trim());
    json!({
        "cpu": cpu.unwrap_or(std::env::consts::ARCH),
        "cores": std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        "os": std::env::consts::OS,
        "version": env!("CARGO_PKG_VERSION"),
        "built": if cfg!(debug_assertions) { "with checks" } else { "release" },
    })
}

/// A table of rows in a CSV file, with the names of their fields as its first line.
///
/// # Errors
/// The file cannot be written.
pub fn write_csv<'a, R: Serialize + 'a>(path: &Path, rows: impl IntoIterator<Item = &'a R>) -> anyhow::Result<()> {
    let named = || path.display().to_string();
    let mut writer = csv::Writer::from_path(path).with_context(named)?;
    for row in rows {
        writer.serialize(row).with_context(named)?;
    }
    writer.flush().with_context(named)
}

/// The `p` quantile of values (0..1), by nearest rank; NaN if there are none.
pub fn quantile(values: impl Iterator<Item = f32>, p: f32) -> f32 {
    let mut sorted: Vec<f32> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f32::total_cmp);
    let rank = (p * sorted.len() as f32).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(f32::NAN)
}
