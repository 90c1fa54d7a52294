//! The head of the page: what it is, key figures, where and how its data were made.

use super::comparison::{self, Comparison};
use super::input::{Inputs, Meta, Run, words};
use super::number::{NONE, duration};
use super::row::ConvergeLine;
use super::{maps, trials};
use maud::{Markup, html};
use std::collections::BTreeMap;

/// A number that people look for first.
pub struct KeyFigure {
    /// The number.
    pub value: String,
    /// Of what.
    pub what: String,
    /// What else is to be known.
    pub note: String,
    /// What it belongs to.
    pub title: String,
    /// The name of the files that it comes from.
    pub stem: String,
}

/// The opening.
pub fn intro(inputs: &Inputs) -> Markup {
    html! {
        h1 { "Tactus: finding an object by touch" }
        p class="lead" {
            "Results of experiments with the simulated arm and hand: the method of Nikandrova (" cite { "Learning Robot Environment through Simulation" }
            ", 2011) and this project's own, on the same problems. Every figure comes from the files named below it; nothing is loaded from elsewhere."
        }
        p class="dates" { (dates(inputs)) }
    }
}

/// From when to when the files were written.
fn dates(inputs: &Inputs) -> String {
    let runs = inputs.runs();
    let days: Vec<&str> =
        runs.iter().filter_map(|(_, _, made)| made.map(|m| m.split('T').next().unwrap_or(m))).collect();
    let total: f64 = runs.iter().filter_map(|(_, meta, _)| meta.wall_time_s).sum();
    let when = match (days.iter().min(), days.iter().max()) {
        (Some(first), Some(last)) if first == last => (*first).to_string(),
        (Some(first), Some(last)) => format!("{first} to {last}"),
        _ => "date unknown".into(),
    };
    let made = if total > 0.0 { format!(", made in {}", duration(total)) } else { String::new() };
    format!("{when} · {} experiments{made} · page by tactus {}", runs.len(), env!("CARGO_PKG_VERSION"))
}

/// The tiles of key figures.
pub fn key_figures(inputs: &Inputs, comparisons: &[Comparison<'_>]) -> Markup {
    const MAPS: usize = 6;
    let leading = leading(&inputs.maps);
    let mut figures: Vec<KeyFigure> = leading.iter().take(MAPS).map(|run| maps::key_figure(run)).collect();
    figures.extend(comparisons.iter().filter_map(comparison::key_figure));
    figures.extend(inputs.trials.iter().map(trials::key_figure));
    html! {
        @if !figures.is_empty() {
            ul class="tiles" {
                @for f in &figures {
                    li {
                        span class="tile-title" { (f.title) }
                        b { (f.value) }
                        span { (f.what) }
                        span class="note" { (f.note) }
                        span class="stem" { (f.stem) }
                    }
                }
            }
            @let more = inputs.maps.len() - leading.len().min(MAPS);
            @if more > 0 { p class="note" { "Not above: " (more) " of " (inputs.maps.len()) " maps; all are in the " a href="#maps" { "table of maps" } "." } }
        }
    }
}

/// One map for each method and task: of those that differ in finer settings the one with the shortest name.
fn leading(maps: &[Run<ConvergeLine>]) -> Vec<&Run<ConvergeLine>> {
    let task = |run: &Run<ConvergeLine>| {
        ["error", "optimizer", "formulation", "noise", "dof"].map(|key| run.meta.setting(key))
    };
    let first = |run: &&Run<ConvergeLine>| {
        let alike = maps.iter().filter(|other| task(other) == task(run));
        alike.min_by_key(|other| (other.stem.len(), &other.stem)).is_some_and(|other| other.stem == run.stem)
    };
    maps.iter().filter(first).collect()
}

/// The machines, and what was run on each.
fn machines(inputs: &Inputs) -> Vec<(String, Vec<String>)> {
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (stem, meta, _) in inputs.runs() {
        all.entry(machine(meta)).or_default().push(stem.to_string());
    }
    all.into_iter().collect()
}

fn machine(meta: &Meta) -> String {
    const KNOWN: [(&str, &str); 5] = [("cpu", ""), ("cores", " cores"), ("os", ""), ("rustc", ""), ("version", "")];
    let known = KNOWN.iter().filter_map(|(key, unit)| {
        let value = meta.machine.get(*key).and_then(words)?;
        let plain = match *key {
            "rustc" if !value.starts_with("rustc") => format!("rustc {value}"),
            "version" => format!("tactus {value}"),
            _ => value,
        };
        Some(format!("{plain}{unit}"))
    });
    let others = meta.machine.iter().filter(|(key, _)| KNOWN.iter().all(|(k, _)| k != key));
    let others = others.filter_map(|(key, value)| words(value).map(|v| format!("{key} {v}")));
    let parts: Vec<String> = known.chain(others).collect();
    if parts.is_empty() { "not recorded".into() } else { parts.join(" · ") }
}

/// How the data were made: machine, commands, seeds.
pub fn provenance(inputs: &Inputs) -> Markup {
    let machines = machines(inputs);
    html! {
        @for (machine, stems) in &machines {
            p { b { "Machine: " } (machine) @if machines.len() > 1 { " (" (stems.join(", ")) ")" } }
        }
        div class="scroll" {
            table class="sortable commands" {
                caption { "The command that made each pair of files. With the same version and seed it makes the same figures again; only times differ." }
                thead { tr { th { "files" } th { "command" } th class="num" { "seed" } th { "written (UTC)" } th class="num" { "took" } } }
                tbody { @for (stem, meta, made) in inputs.runs() { tr {
                    td { code { (stem) ".csv, .json" } }
                    td { code { (meta.command) } }
                    td class="num" { (meta.setting("seed").unwrap_or(NONE.into())) }
                    td { (made.unwrap_or(NONE).replace('T', " ").trim_end_matches('Z')) }
                    td class="num" data-v=[meta.wall_time_s] { (meta.wall_time_s.map_or(NONE.into(), duration)) }
                } } }
            }
        }
    }
}
