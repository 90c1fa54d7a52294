//! The lines of each kind of experiment's CSV.

use super::table::{Row, Table};
use crate::experiment::converge::Class;
use crate::experiment::observability::Class as Verdict;
use std::path::Path;

/// A line of a CSV file of a kind.
pub trait Line: Sized {
    /// The value of `experiment` in the JSON beside it.
    const EXPERIMENT: &'static str;
    /// The columns it needs.
    const COLUMNS: &'static [&'static str];

    /// Reads one line.
    ///
    /// # Errors
    /// A field is not what it should be.
    fn read(row: &Row<'_>) -> anyhow::Result<Self>;

    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or a field is not what it should be.
    fn read_all(path: &Path) -> anyhow::Result<Vec<Self>> {
        Table::read(path, Self::COLUMNS)?.rows(Self::read)
    }
}

/// A pose in the world: metres, metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At {
    /// x, metres.
    pub x: f64,
    /// y, metres.
    pub y: f64,
    /// Yaw, radians.
    pub phi: f64,
}

impl At {
    fn read(row: &Row<'_>) -> anyhow::Result<Self> {
        Ok(Self { x: row.number("x")?, y: row.number("y")?, phi: row.number("phi")? })
    }
}

/// The error at one pose.
#[derive(Clone, Debug)]
pub struct SurfaceLine {
    /// The hypothesised pose.
    pub at: At,
    /// The error there, or why there is none.
    pub error: Result<f64, String>,
}

impl Line for SurfaceLine {
    const EXPERIMENT: &'static str = "surface";
    const COLUMNS: &'static [&'static str] = &["x", "y", "phi", "error", "outcome"];

    fn read(row: &Row<'_>) -> anyhow::Result<Self> {
        let error = match row.text("outcome") {
            "" => return Err(row.wrong("outcome", "ok, or why there is no error value")),
            "ok" => Ok(row.number("error")?),
            // A number where nothing was evaluated could be taken for an error value.
            _ if !row.text("error").is_empty() => {
                return Err(row.wrong("error", "nothing, since the outcome is not ok"));
            }
            reason => Err(reason.to_string()),
        };
        Ok(Self { at: At::read(row)?, error })
    }
}

/// A search from one start.
#[derive(Clone, Debug)]
pub struct ConvergeLine {
    /// The start.
    pub at: At,
    /// What became of it.
    pub class: Class,
    /// The error where it ended.
    pub final_error: Option<f64>,
    /// Distance of the end from the truth, metres.
    pub location_m: Option<f64>,
    /// Angle between end and truth, radians.
    pub yaw_rad: Option<f64>,
    /// Error evaluations.
    pub evaluations: Option<f64>,
    /// Time of the optimiser, seconds.
    pub time_s: Option<f64>,
    /// Why it stopped.
    pub stop_reason: String,
}

impl Line for ConvergeLine {
    const EXPERIMENT: &'static str = "converge";
    const COLUMNS: &'static [&'static str] = &[
        "x",
        "y",
        "phi",
        "class",
        "final_error",
        "location_error_m",
        "yaw_error_rad",
        "evaluations",
        "time_s",
        "stop_reason",
    ];

    fn read(row: &Row<'_>) -> anyhow::Result<Self> {
        let words = Class::ALL.map(|class| (class.name(), class));
        Ok(Self {
            at: At::read(row)?,
            class: row.choice("class", &words)?,
            final_error: row.number_or_none("final_error")?,
            location_m: row.number_or_none("location_error_m")?,
            yaw_rad: row.number_or_none("yaw_error_rad")?,
            evaluations: row.number_or_none("evaluations")?,
            time_s: row.number_or_none("time_s")?,
            stop_reason: row.text("stop_reason").to_string(),
        })
    }
}

/// One optimiser on one problem at one budget.
#[derive(Clone, Debug)]
pub struct CompareLine {
    /// Uncertain components of the pose.
    pub dof: u64,
    /// Error function.
    pub error: String,
    /// Optimiser.
    pub optimizer: String,
    /// Evaluations it was allowed.
    pub budget: u64,
    /// Distance of the end from the truth, metres.
    pub location_m: Option<f64>,
    /// Evaluations it used.
    pub evaluations: Option<f64>,
    /// Its time, seconds.
    pub time_s: Option<f64>,
    /// The evidence determines the pose.
    pub observable: bool,
}

impl Line for CompareLine {
    const EXPERIMENT: &'static str = "compare";
    const COLUMNS: &'static [&'static str] = &[
        "problem",
        "dof",
        "error",
        "optimizer",
        "budget",
        "location_error_m",
        "yaw_error_rad",
        "final_error",
        "evaluations",
        "time_s",
        "stop_reason",
        "observability",
    ];

    fn read(row: &Row<'_>) -> anyhow::Result<Self> {
        Ok(Self {
            dof: row.count("dof")?,
            error: row.text("error").to_string(),
            optimizer: row.text("optimizer").to_string(),
            budget: row.count("budget")?,
            location_m: row.number_or_none("location_error_m")?,
            evaluations: row.number_or_none("evaluations")?,
            time_s: row.number_or_none("time_s")?,
            observable: row.choice("observability", &[("observable", true), ("not observable", false)])?,
        })
    }
}

/// One mission of a batch.
#[derive(Clone, Debug)]
pub struct TrialLine {
    /// Its seed.
    pub seed: u64,
    /// Its verdict.
    pub verdict: Verdict,
    /// Distance of belief and truth, metres.
    pub location_m: Option<f64>,
    /// Angle between belief and truth, radians.
    pub yaw_rad: Option<f64>,
    /// Standard deviations that the controller believed: x, y, metres.
    pub sd_m: [Option<f64>; 2],
    /// The truth lies outside what the controller thought possible.
    pub confidently_wrong: bool,
    /// Touches.
    pub touches: u64,
    /// What came of it.
    pub outcome: String,
}

impl Line for TrialLine {
    const EXPERIMENT: &'static str = "trials";
    const COLUMNS: &'static [&'static str] =
        &["seed", "position_error_m", "yaw_error_rad", "confidently_wrong", "trials", "outcome", "class"];

    fn read(row: &Row<'_>) -> anyhow::Result<Self> {
        let words = Verdict::ALL.map(|v| (v.name(), v));
        Ok(Self {
            seed: row.count("seed")?,
            verdict: row.choice("class", &words)?,
            location_m: row.number_or_none("position_error_m")?,
            yaw_rad: row.number_or_none("yaw_error_rad")?,
            sd_m: [row.number_or_none("sd_x_m")?, row.number_or_none("sd_y_m")?],
            confidently_wrong: row.choice("confidently_wrong", &[("true", true), ("false", false)])?,
            touches: row.count("trials")?,
            outcome: row.text("outcome").to_string(),
        })
    }
}
