//! Comparison of all methods on the same problems.

mod chart;
mod overview;

use super::head::KeyFigure;
use super::input::Run;
use super::number::{NONE, mm, percent, quantile, share, sig};
use super::row::CompareLine;
use anyhow::Context;
use maud::{Markup, html};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The budget at which methods are judged.
const BUDGET: u64 = 100;

/// One method at one budget.
#[derive(Deserialize, Clone, Debug)]
pub struct Entry {
    dof: u64,
    error: String,
    optimizer: String,
    budget: u64,
    problems: usize,
    median_m: Option<f64>,
    p90_m: Option<f64>,
    within_2mm: f64,
    within_10mm: f64,
    evaluations_median: Option<f64>,
    time_median_s: Option<f64>,
    /// Share within 2 mm of those problems whose evidence determines the pose; from the lines.
    #[serde(skip)]
    observable_2mm: Option<f64>,
}

type Key<'a> = (u64, u64, &'a str, &'a str);

/// Lines by (degrees of freedom, budget, error, optimiser).
fn by_method(rows: &[CompareLine]) -> BTreeMap<Key<'_>, Vec<&CompareLine>> {
    let mut methods: BTreeMap<Key<'_>, Vec<&CompareLine>> = BTreeMap::new();
    for row in rows {
        methods.entry((row.dof, row.budget, &row.error, &row.optimizer)).or_default().push(row);
    }
    methods
}

fn within(rows: &[&CompareLine], metres: f64) -> f64 {
    share(rows.iter().filter(|r| r.location_m.is_some_and(|m| m <= metres)).count(), rows.len())
}

fn computed((dof, budget, error, optimizer): Key<'_>, rows: &[&CompareLine]) -> Entry {
    let median =
        |value: fn(&CompareLine) -> Option<f64>| quantile(rows.iter().map(|r| value(r)), 0.5).filter(|v| v.is_finite());
    Entry {
        dof,
        error: error.into(),
        optimizer: optimizer.into(),
        budget,
        problems: rows.len(),
        median_m: quantile(rows.iter().map(|r| r.location_m), 0.5),
        p90_m: quantile(rows.iter().map(|r| r.location_m), 0.9),
        within_2mm: within(rows, 0.002),
        within_10mm: within(rows, 0.010),
        evaluations_median: median(|r| r.evaluations),
        time_median_s: median(|r| r.time_s),
        observable_2mm: None,
    }
}

/// The table of a file: that of its JSON, or, where it has none, computed from its lines.
///
/// # Errors
/// The table in the JSON is not one.
pub fn entries(run: &Run<CompareLine>) -> anyhow::Result<Vec<Entry>> {
    let methods = by_method(&run.rows);
    let mut entries: Vec<Entry> = match run.meta.statistics.get("table") {
        Some(table) => Deserialize::deserialize(table)
            .with_context(|| format!("{}.json: statistics.table: expected the columns of a comparison", run.stem))?,
        None => methods.iter().map(|(key, rows)| computed(*key, rows)).collect(),
    };
    for entry in &mut entries {
        let lines = methods.get(&(entry.dof, entry.budget, entry.error.as_str(), entry.optimizer.as_str()));
        let seen: Vec<&CompareLine> = lines.into_iter().flatten().filter(|r| r.observable).copied().collect();
        entry.observable_2mm = (!seen.is_empty()).then(|| within(&seen, 0.002));
    }
    let place = |e: &Entry| (e.dof, e.budget, e.error.clone(), e.optimizer.clone());
    entries.sort_by_key(place);
    Ok(entries)
}

/// The budget nearest to the one of judgement.
fn judged(entries: &[Entry]) -> u64 {
    entries.iter().map(|e| e.budget).min_by_key(|b| b.abs_diff(BUDGET)).unwrap_or(BUDGET)
}

/// A comparison with its table.
pub struct Comparison<'a> {
    /// The files.
    pub run: &'a Run<CompareLine>,
    /// The table.
    pub entries: Vec<Entry>,
}

/// The section.
pub fn section(all: &[Comparison<'_>]) -> Markup {
    html! {
        p {
            "Every method had the same problems (stored evidence, bounds, starts) and may evaluate its error as often as the budget says. "
            "The location error is the distance of its answer from the true place. Problems whose evidence does not determine the pose are among them; "
            "the column “of the observable” leaves them out."
        }
        @for Comparison { run, entries } in all {
            h3 { (run.meta.title) " " span class="stem" { (run.stem) } }
            p class="settings" { (run.meta.describe()) " · file " (run.stem) ".csv" }
            @let budget = judged(entries);
            @let here: Vec<&Entry> = entries.iter().filter(|e| e.budget == budget).collect();
            (overview::table(&here, budget))
            (chart::charts(run, entries, budget))
            (table(&here, &format!("All methods at a budget of {budget} evaluations (on a screen a long table scrolls).")))
            @if here.len() < entries.len() {
                (table(&entries.iter().collect::<Vec<_>>(), "All methods at all budgets (on a screen a long table scrolls)."))
            }
        }
    }
}

/// A column in which there is a best value.
struct Column {
    head: &'static str,
    value: fn(&Entry) -> Option<f64>,
    text: fn(f64) -> String,
    more_is_better: bool,
}

const COLUMNS: [Column; 7] = [
    Column { head: "median (mm)", value: |e| e.median_m, text: |v| mm(Some(v)), more_is_better: false },
    Column { head: "90 % (mm)", value: |e| e.p90_m, text: |v| mm(Some(v)), more_is_better: false },
    Column { head: "within 2 mm (%)", value: |e| Some(e.within_2mm), text: percent, more_is_better: true },
    Column { head: "of the observable (%)", value: |e| e.observable_2mm, text: percent, more_is_better: true },
    Column { head: "within 10 mm (%)", value: |e| Some(e.within_10mm), text: percent, more_is_better: true },
    Column { head: "evaluations", value: |e| e.evaluations_median, text: |v| sig(v, 4), more_is_better: false },
    Column { head: "time (ms)", value: |e| e.time_median_s, text: |v| sig(v * 1e3, 3), more_is_better: false },
];

impl Column {
    /// What is compared is what is shown: two values that read the same are equally good.
    fn shown(&self, entry: &Entry) -> Option<String> {
        (self.value)(entry).map(self.text)
    }

    /// The best value among `entries` as it is shown; `None` where most share it: then it distinguishes none.
    fn best(&self, entries: &[&Entry]) -> Option<String> {
        let sign = if self.more_is_better { -1.0 } else { 1.0 };
        let known = entries.iter().filter_map(|e| (self.value)(e).map(|v| (sign * v, *e)));
        let best = known.min_by(|a, b| a.0.total_cmp(&b.0)).and_then(|(_, e)| self.shown(e))?;
        let sharing = entries.iter().filter(|e| self.shown(e).as_deref() == Some(&best)).count();
        (sharing == 1 || 2 * sharing <= entries.len()).then_some(best)
    }
}

/// The table of a group: rows with the same problems and the same budget stand together and are sorted together.
fn table(entries: &[&Entry], caption: &str) -> Markup {
    let mut groups: BTreeMap<(u64, u64), Vec<&Entry>> = BTreeMap::new();
    for entry in entries {
        groups.entry((entry.dof, entry.budget)).or_default().push(entry);
    }
    for group in groups.values_mut() {
        let median = |e: &Entry| e.median_m.unwrap_or(f64::INFINITY);
        group.sort_by(|a, b| b.within_2mm.total_cmp(&a.within_2mm).then(median(a).total_cmp(&median(b))));
    }
    html! {
        div class="scroll tall" {
            table class="sortable dense methods" {
                caption {
                    (caption) " Evaluations and time: medians. The methods with the same degrees of freedom and budget stand together, those with most within 2 mm first; "
                    "★ and bold: the best of its column among them, unless most share it."
                }
                thead { tr {
                    th { "error" } th { "optimiser" } th class="num" { "DOF" } th class="num" { "budget" } th class="num" { "problems" }
                    @for column in &COLUMNS { th class="num" { (column.head) } }
                } }
                @for group in groups.values() {
                    @let best: Vec<Option<String>> = COLUMNS.iter().map(|c| c.best(group)).collect();
                    tbody { @for entry in group { (row(entry, &best)) } }
                }
            }
        }
    }
}

fn row(entry: &Entry, best: &[Option<String>]) -> Markup {
    html! {
        tr {
            td { (entry.error) }
            td class="name" { (entry.optimizer) }
            @for count in [entry.dof, entry.budget, entry.problems as u64] { td class="num" { (count) } }
            @for (column, best) in COLUMNS.iter().zip(best) {
                @let shown = column.shown(entry);
                td class="num" data-v=[(column.value)(entry)] {
                    @if shown.is_some() && shown == *best { b class="best" { "★ " (shown.unwrap_or_default()) } }
                    @else { (shown.unwrap_or(NONE.into())) }
                }
            }
        }
    }
}

/// The key figure: the best method with the most degrees of freedom.
pub fn key_figure(Comparison { run, entries }: &Comparison<'_>) -> Option<KeyFigure> {
    let budget = judged(entries);
    let dof = entries.iter().map(|e| e.dof).max()?;
    let judged = entries.iter().filter(|e| e.dof == dof && e.budget == budget);
    let best = judged.max_by(|a, b| a.within_2mm.total_cmp(&b.within_2mm))?;
    Some(KeyFigure {
        value: format!("{} %", percent(best.within_2mm)),
        what: format!("within 2 mm: {} with {}", best.optimizer, best.error),
        note: format!("best of {dof}-DOF at {budget} evaluations; median {} mm", mm(best.median_m)),
        title: run.meta.title.clone(),
        stem: run.stem.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(within_2mm: f64, median_m: Option<f64>) -> Entry {
        let (error, optimizer) = (String::new(), String::new());
        let times = (Some(90.0), Some(1e-3));
        Entry {
            dof: 2,
            error,
            optimizer,
            budget: 100,
            problems: 10,
            median_m,
            p90_m: None,
            within_2mm,
            within_10mm: 1.0,
            evaluations_median: times.0,
            time_median_s: times.1,
            observable_2mm: None,
        }
    }

    #[test]
    fn the_best_of_a_column_is_marked_unless_most_share_it_or_nobody_has_it() {
        let entries = [entry(0.5, Some(0.004)), entry(0.9, Some(0.001)), entry(0.9, None), entry(0.2, Some(0.03))];
        let group: Vec<&Entry> = entries.iter().collect();
        let best: Vec<Option<String>> = COLUMNS.iter().map(|c| c.best(&group)).collect();
        let (median, share) = (Some("1".to_string()), Some("90".to_string()));
        assert_eq!(best, [median, None, share, None, None, None, None]);
    }
}
