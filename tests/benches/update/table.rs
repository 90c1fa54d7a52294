//! The comparison, as a table for people and as JSON.

use crate::{Contender, ours};
use serde_json::{Value, json};

/// The search of ours to which others are set in relation at the same budget.
const SEARCH: &str = "levenberg-marquardt";

/// One contender at one budget.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The crate it is of.
    pub origin: &'static str,
    /// Its name there.
    pub name: &'static str,
    /// Evaluations that it might make.
    pub budget: u16,
    /// Bytes of its state, where known.
    pub bytes: Option<usize>,
    /// What must be known about it.
    pub note: &'static str,
    /// Metres.
    pub location_error_median_m: f64,
    /// Share of the problems, 0..1.
    pub within_2mm: f64,
    /// Evaluations that it did make.
    pub evaluations_median: f64,
    /// Seconds.
    pub time_median_s: f64,
    /// Time to that of our default update.
    pub to_default: f64,
    /// Time to that of our Levenberg-Marquardt search at the same budget.
    pub to_search: f64,
}

impl Row {
    /// For the report.
    pub fn json(&self) -> Value {
        json!({
            "crate": self.origin, "optimizer": self.name, "budget": self.budget, "bytes": self.bytes,
            "note": self.note, "location_error_median_m": self.location_error_median_m,
            "within_2mm": self.within_2mm, "evaluations_median": self.evaluations_median,
            "time_median_s": self.time_median_s, "time_to_default": self.to_default,
            "time_to_levenberg_marquardt": self.to_search,
        })
    }
}

/// Works out the ratios of rows of one budget.
pub fn set_ratios(rows: &mut [Row]) {
    let time_of = |name| rows.iter().find(|r| r.origin == ours::ORIGIN && r.name == name).map(|r| r.time_median_s);
    let (default_s, search_s) = (time_of(ours::DEFAULT), time_of(SEARCH));
    for row in rows {
        row.to_default = default_s.map_or(f64::NAN, |s| row.time_median_s / s);
        row.to_search = search_s.map_or(f64::NAN, |s| row.time_median_s / s);
    }
}

/// Prints the rows of one budget.
pub fn print(rows: &[Row], budget: u16) {
    println!("\nat most {budget} evaluations");
    println!(
        "{:8} {:26} {:>9} {:>8} {:>6} {:>9} {:>9} {:>9} {:>7} {:>6}",
        "crate", "optimiser", "median mm", "<= 2 mm", "evals", "time us", "x default", "x LM here", "us/eval", "bytes"
    );
    for row in rows {
        println!(
            "{:8} {:26} {:>9.2} {:>7.0}% {:>6.0} {:>9.1} {:>9.2} {:>9.2} {:>7.2} {:>6}",
            row.origin,
            row.name,
            row.location_error_median_m * 1e3,
            row.within_2mm * 100.0,
            row.evaluations_median,
            row.time_median_s * 1e6,
            row.to_default,
            row.to_search,
            row.time_median_s * 1e6 / row.evaluations_median,
            row.bytes.map_or_else(|| "-".to_owned(), |b| b.to_string()),
        );
    }
}

/// What must be known to read the tables.
pub fn notes(contenders: &[Contender]) -> Vec<String> {
    let mut notes = vec![
        "All minimise the geometric error with the wide loss (30 standard deviations) from the guess, in half widths of"
            .to_owned(),
        "the interval, each with its crate's own defaults; value and analytic slope at one pose are one evaluation."
            .to_owned(),
        format!("x default: time to our whole update; x LM here: to our {SEARCH} search at the same budget."),
    ];
    for contender in contenders.iter().filter(|c| !c.note.is_empty()) {
        notes.push(format!("{} {}: {}.", contender.origin, contender.name, contender.note));
    }
    notes
}
