//! What one setting does while all others stay: gradient, degrees of freedom, damping, instants.

use super::input::{Meta, Run};
use super::maps::{Figures, class_heads, figure_cells};
use super::row::ConvergeLine;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// Settings with a table of their own, and its title.
const FACTORS: [(&str, &str); 4] = [
    ("gradient", "Gradient: one-sided or two-sided differences"),
    ("dof", "Degrees of freedom"),
    ("damping", "Damping constant of the weights (eq. 22)"),
    ("instants", "Instants in the contact matrix"),
];

/// Runs that differ in one setting only.
pub struct Group<'a> {
    title: &'static str,
    factor: &'static str,
    shared: String,
    runs: Vec<&'a Run<ConvergeLine>>,
}

/// All settings but `factor`, and how many runs at a time, which changes no result.
fn others(meta: &Meta, factor: &str) -> String {
    let kept = meta.settings.iter().filter(|(k, v)| *k != factor && *k != "jobs" && !v.is_null());
    kept.map(|(k, v)| format!("{k}={v};")).collect()
}

/// The tables that these files make.
pub fn groups(runs: &[Run<ConvergeLine>]) -> Vec<Group<'_>> {
    let mut groups = Vec::new();
    for (factor, title) in FACTORS {
        let mut alike: BTreeMap<String, Vec<&Run<ConvergeLine>>> = BTreeMap::new();
        for run in runs.iter().filter(|r| r.meta.setting(factor).is_some()) {
            alike.entry(others(&run.meta, factor)).or_default().push(run);
        }
        for mut runs in alike.into_values() {
            let order = |r: &&Run<ConvergeLine>| r.meta.settings.get(factor).and_then(serde_json::Value::as_f64);
            runs.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(std::cmp::Ordering::Equal));
            let first = runs[0].meta.setting(factor);
            if runs.iter().any(|r| r.meta.setting(factor) != first) {
                let without = |part: &&str| !part.starts_with(&format!("{factor} "));
                let described = runs[0].meta.describe();
                let shared = described.split(" · ").filter(without).collect::<Vec<_>>().join(" · ");
                groups.push(Group { title, factor, shared, runs });
            }
        }
    }
    groups
}

/// The section.
pub fn section(groups: &[Group<'_>]) -> Markup {
    html! {
        p { "Each table compares maps that differ in one setting only. What they share stands beside the title. Evaluations: mean per start. Time: the optimiser's, all starts." }
        @for group in groups {
            div class="scroll" {
                table class="sortable" {
                    caption { b { (group.title) } ". " span class="settings" { (group.shared) } }
                    thead { tr {
                        th { (group.factor) } th class="num" { "starts" } (class_heads())
                        th class="num" { "median (mm)" } th class="num" { "90 % (mm)" } th class="num" { "largest (mm)" }
                        th class="num" { "evaluations" } th class="num" { "time (s)" } th { "file" }
                    } }
                    tbody {
                        @for run in &group.runs {
                            tr {
                                td { (run.meta.setting(group.factor).unwrap_or_default()) }
                                (figure_cells(&Figures::of(run)))
                                td class="name" { code { (run.stem) } }
                            }
                        }
                    }
                }
            }
        }
    }
}
