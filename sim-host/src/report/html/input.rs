//! Finds the outputs of experiments in a directory and reads them.

use super::row::{CompareLine, ConvergeLine, Line, SurfaceLine, TrialLine};
use anyhow::{Context, ensure};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The file of benchmark figures.
const BENCH: &str = "bench.json";

/// What an experiment writes beside its CSV.
#[derive(Deserialize, Debug)]
pub struct Meta {
    /// The kind of experiment.
    experiment: String,
    /// One line for people.
    pub title: String,
    /// The command line that made it.
    pub command: String,
    /// The settings that apply.
    #[serde(default)]
    pub settings: Map<String, Value>,
    /// The true pose, where one is fixed.
    pub truth: Option<Truth>,
    /// The grid, where there is one.
    pub grid: Option<Grid>,
    /// What was computed from the lines.
    #[serde(default)]
    pub statistics: Map<String, Value>,
    /// Where it ran.
    #[serde(default)]
    pub machine: Map<String, Value>,
    /// How long it took, seconds.
    pub wall_time_s: Option<f64>,
}

/// The true pose: metres, metres, radians.
#[derive(Deserialize, Clone, Copy, Debug)]
pub struct Truth {
    /// x, metres.
    pub x: f64,
    /// y, metres.
    pub y: f64,
    /// Yaw, radians.
    #[serde(default)]
    pub phi: f64,
}

/// First value, last value and step of each component.
#[derive(Deserialize, Clone, Copy, Debug)]
pub struct Grid {
    /// x, metres.
    pub x: Option<[f64; 3]>,
    /// y, metres.
    pub y: Option<[f64; 3]>,
}

/// One experiment: its JSON and its CSV.
pub struct Run<T> {
    /// The name of its files without extension.
    pub stem: String,
    /// The JSON.
    pub meta: Meta,
    /// When the JSON was written.
    pub made: Option<String>,
    /// The CSV.
    pub rows: Vec<T>,
}

/// One figure of a benchmark.
#[derive(Deserialize, Debug)]
pub struct Figure {
    /// What was measured.
    pub name: String,
    /// How much.
    pub value: f64,
    /// Of what.
    pub unit: String,
    /// What is to be known about it.
    #[serde(default)]
    pub note: String,
}

/// One optimiser on the problems of a benchmark.
#[derive(Deserialize, Debug)]
pub struct Timed {
    /// The crate that it comes from.
    #[serde(rename = "crate")]
    pub origin: String,
    /// Its name.
    pub optimizer: String,
    /// Evaluations it was allowed.
    pub budget: u64,
    /// Median location error, metres.
    pub location_error_median_m: Option<f64>,
    /// Share of problems within 2 mm.
    pub within_2mm: Option<f64>,
    /// Median of its evaluations.
    pub evaluations_median: Option<f64>,
    /// Median time of an update, seconds.
    pub time_median_s: Option<f64>,
    /// That time as a multiple of the default method's.
    pub time_to_default: Option<f64>,
}

/// The figures of a benchmark, and how they were made.
#[derive(Deserialize, Debug, Default)]
pub struct Bench {
    /// The figures.
    pub figures: Vec<Figure>,
    /// Pose updates.
    #[serde(default)]
    pub table: Vec<Timed>,
    /// The command line.
    #[serde(default)]
    pub command: Value,
    /// The settings.
    #[serde(default)]
    pub settings: Value,
    /// Where it ran.
    #[serde(default)]
    pub machine: Value,
    /// The crates that it compares with.
    #[serde(default)]
    pub crates: Value,
}

/// Everything in a directory.
#[derive(Default)]
pub struct Inputs {
    /// Error surfaces.
    pub surfaces: Vec<Run<SurfaceLine>>,
    /// Maps of convergence.
    pub maps: Vec<Run<ConvergeLine>>,
    /// Comparisons of methods.
    pub comparisons: Vec<Run<CompareLine>>,
    /// Batches of missions.
    pub trials: Vec<Run<TrialLine>>,
    /// Benchmarks.
    pub bench: Option<Bench>,
    /// Files that are no output of an experiment, and why.
    pub ignored: Vec<(PathBuf, String)>,
}

impl Inputs {
    /// Reads a directory; `out` is the page that is to be written and no input.
    ///
    /// # Errors
    /// The directory cannot be read, holds no experiment, or one of its experiments is malformed: file, place, what was expected.
    pub fn read(dir: &Path, out: Option<&Path>) -> anyhow::Result<Self> {
        let mut files: Vec<PathBuf> = std::fs::read_dir(dir)
            .and_then(|entries| entries.map(|e| e.map(|e| e.path())).collect())
            .with_context(|| format!("{}", dir.display()))?;
        files.sort();
        let mut inputs = Self::default();
        for path in files.iter().filter(|p| p.file_name() != out.and_then(Path::file_name)) {
            if let Err(reason) = inputs.take(path, &files)? {
                inputs.ignored.push((path.clone(), reason));
            }
        }
        inputs.surfaces.sort_by_key(|run| (run.meta.order(), run.stem.clone()));
        inputs.maps.sort_by_key(|run| (run.meta.order(), run.stem.clone()));
        ensure!(
            !inputs.is_empty(),
            "{}: no output of an experiment; expected pairs STEM.csv, STEM.json",
            dir.display()
        );
        Ok(inputs)
    }

    fn is_empty(&self) -> bool {
        self.surfaces.is_empty()
            && self.maps.is_empty()
            && self.comparisons.is_empty()
            && self.trials.is_empty()
            && self.bench.is_none()
    }

    /// Reads one file; the inner error says why it is no output of an experiment.
    fn take(&mut self, path: &Path, all: &[PathBuf]) -> anyhow::Result<Result<(), String>> {
        let csv = path.with_extension("csv");
        let paired = all.contains(&csv);
        match path.extension().and_then(OsStr::to_str) {
            _ if path.is_dir() => return Ok(Err("a directory".into())),
            Some("csv") if all.contains(&path.with_extension("json")) => return Ok(Ok(())),
            Some("csv") => return Ok(Err("no JSON of the same name beside it".into())),
            Some("json") => {}
            _ => return Ok(Err("neither CSV nor JSON".into())),
        }
        let name = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("{name}"))?;
        if path.file_name() == Some(OsStr::new(BENCH)) {
            let expected = || format!("{name}: expected figures: [{{name, value, unit, note}}]");
            // With what is to be known about them, or alone.
            self.bench = Some(if text.trim_start().starts_with('[') {
                Bench { figures: serde_json::from_str(&text).with_context(expected)?, ..Bench::default() }
            } else {
                serde_json::from_str(&text).with_context(expected)?
            });
            return Ok(Ok(()));
        }
        let value: Value = match serde_json::from_str(&text) {
            Ok(value) => value,
            Err(error) if !paired => return Ok(Err(format!("not JSON: {error}"))),
            Err(error) => return Err(error).with_context(|| format!("{name}: expected JSON")),
        };
        let Some(kind) = value.get("experiment").and_then(Value::as_str).map(str::to_string) else {
            return Ok(Err("it names no experiment".into()));
        };
        // From the text again: these errors name line and column.
        let meta = || -> anyhow::Result<Meta> {
            serde_json::from_str(&text).with_context(|| format!("{name}: expected the settings of an experiment"))
        };
        match kind.as_str() {
            SurfaceLine::EXPERIMENT => self.surfaces.push(run(path, &csv, meta()?, paired)?),
            ConvergeLine::EXPERIMENT => self.maps.push(run(path, &csv, meta()?, paired)?),
            CompareLine::EXPERIMENT => self.comparisons.push(run(path, &csv, meta()?, paired)?),
            TrialLine::EXPERIMENT => self.trials.push(run(path, &csv, meta()?, paired)?),
            other => return Ok(Err(format!("no section for an experiment '{other}'"))),
        }
        Ok(Ok(()))
    }

    /// What is told of every experiment: name of its files, JSON, time of writing.
    pub fn runs(&self) -> Vec<(&str, &Meta, Option<&str>)> {
        fn told<T>(run: &Run<T>) -> (&str, &Meta, Option<&str>) {
            (&run.stem, &run.meta, run.made.as_deref())
        }
        let mut all: Vec<_> = self.surfaces.iter().map(told).collect();
        all.extend(self.maps.iter().map(told));
        all.extend(self.comparisons.iter().map(told));
        all.extend(self.trials.iter().map(told));
        all
    }
}

fn run<T: Line>(path: &Path, csv: &Path, meta: Meta, paired: bool) -> anyhow::Result<Run<T>> {
    ensure!(
        paired,
        "{}: no such file; expected the lines of the {} in {}",
        csv.display(),
        meta.experiment,
        path.display()
    );
    let modified = std::fs::metadata(path).and_then(|m| m.modified()).ok();
    Ok(Run {
        stem: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        meta,
        made: modified.map(|time| humantime::format_rfc3339_seconds(time).to_string()),
        rows: T::read_all(csv)?,
    })
}

impl Meta {
    /// A setting in words; `None` if it is not there.
    pub fn setting(&self, key: &str) -> Option<String> {
        self.settings.get(key).and_then(words)
    }

    /// Its place among its like: few degrees of freedom first, then in the order of the thesis, ours last, then without noise first.
    fn order(&self) -> (Option<u64>, usize, bool) {
        const ERRORS: [&str; 4] = ["contact", "weighted", "modified", "geometric"];
        let error = self.setting("error").and_then(|e| ERRORS.iter().position(|known| *known == e));
        let noise = self.settings.get("noise").and_then(Value::as_bool);
        (self.settings.get("dof").and_then(Value::as_u64), error.unwrap_or(ERRORS.len()), noise.unwrap_or(false))
    }

    /// A number among the statistics.
    pub fn statistic(&self, key: &str) -> Option<f64> {
        self.statistics.get(key).and_then(Value::as_f64)
    }

    /// All settings in one line, those that tell most first.
    pub fn describe(&self) -> String {
        const FIRST: [&str; 13] = [
            "error",
            "optimizer",
            "predictor",
            "formulation",
            "gradient",
            "sensors",
            "noise",
            "dof",
            "damping",
            "instants",
            "budget",
            "seed",
            "threshold",
        ];
        let first = FIRST.iter().copied().filter(|key| self.settings.contains_key(*key));
        let rest = self.settings.keys().map(String::as_str).filter(|key| !FIRST.contains(key));
        let parts = first.chain(rest).filter_map(|key| self.setting(key).map(|v| format!("{key} {v}")));
        parts.collect::<Vec<_>>().join(" · ")
    }
}

/// A JSON value in words; `None` for null.
pub fn words(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::Bool(b) => Some(if *b { "yes" } else { "no" }.into()),
        // Single precision widened to double has digits that say nothing.
        Value::Number(n) if n.is_f64() => n.as_f64().map(|v| super::number::sig(v, 6)),
        Value::Number(n) => Some(n.to_string()),
        Value::String(s) => Some(s.clone()),
        Value::Array(a) => Some(a.iter().filter_map(words).collect::<Vec<_>>().join(", ")),
        Value::Object(o) => {
            Some(o.iter().filter_map(|(k, v)| words(v).map(|v| format!("{k} {v}"))).collect::<Vec<_>>().join(", "))
        }
    }
}
