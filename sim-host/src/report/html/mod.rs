//! One self-contained page of all the experiments in a directory.

mod bench;
mod colour;
mod comparison;
mod head;
mod heat;
mod input;
mod maps;
mod number;
mod page;
mod raster;
mod row;
mod sensitivity;
mod surfaces;
mod svg;
mod table;
#[cfg(test)]
mod tests;
mod trials;

pub use colour::CIVIDIS;
pub use page::PALETTE;

use comparison::Comparison;
use input::Inputs;
use page::Section;
use std::path::{Path, PathBuf};
use trials::Batch;

/// A page, and what it is made of.
pub struct Page {
    /// The HTML.
    pub html: String,
    /// Files of the directory that are no output of an experiment, and why.
    pub ignored: Vec<(PathBuf, String)>,
    /// What is in it, for people.
    pub contents: String,
}

/// Makes the page of a directory; `out`, if it lies there, is not an input.
///
/// # Errors
/// The directory cannot be read, holds no experiment, or a file of an experiment is malformed: file, line, column, what was expected.
pub fn make(dir: &Path, out: Option<&Path>) -> anyhow::Result<Page> {
    let inputs = Inputs::read(dir, out)?;
    let comparisons = inputs
        .comparisons
        .iter()
        .map(|run| comparison::entries(run).map(|entries| Comparison { run, entries }))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let batches = inputs
        .trials
        .iter()
        .map(|run| trials::by_touch(run).map(|by_touch| Batch { run, by_touch }))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let groups = sensitivity::groups(&inputs.maps);
    let bench = inputs.bench.as_ref();
    let sections = [
        Section::new("provenance", "How these figures were made", true, || head::provenance(&inputs)),
        Section::new("surfaces", "Error surfaces", !inputs.surfaces.is_empty(), || surfaces::section(&inputs.surfaces)),
        Section::new("maps", "Maps of convergence", !inputs.maps.is_empty(), || maps::section(&inputs.maps)),
        Section::new("sensitivity", "Sensitivity", !groups.is_empty(), || sensitivity::section(&groups)),
        Section::new("comparison", "Comparison of methods", !comparisons.is_empty(), || {
            comparison::section(&comparisons)
        }),
        Section::new("trials", "Missions and observability", !batches.is_empty(), || trials::section(&batches)),
        Section::new("bench", "Benchmarks", bench.is_some(), || bench.map(bench::section).unwrap_or_default()),
    ];
    let counts = [
        (inputs.surfaces.len(), "surfaces"),
        (inputs.maps.len(), "maps of convergence"),
        (inputs.comparisons.len(), "comparisons"),
        (inputs.trials.len(), "batches of missions"),
        (bench.map_or(0, |b| b.figures.len()), "benchmark figures"),
    ];
    let counted = counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}"));
    Ok(Page {
        contents: counted.collect::<Vec<_>>().join(", "),
        html: page::page(&head::intro(&inputs), &head::key_figures(&inputs, &comparisons), &sections).into_string(),
        ignored: inputs.ignored,
    })
}
