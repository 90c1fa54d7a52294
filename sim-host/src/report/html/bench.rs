//! Benchmarks.

use super::input::{Bench, Timed, words};
use super::number::{NONE, mm, percent, sig};
use maud::{Markup, html};

/// The section.
pub fn section(bench: &Bench) -> Markup {
    let told = [
        ("Command", &bench.command),
        ("Settings", &bench.settings),
        ("Machine", &bench.machine),
        ("Crates", &bench.crates),
    ];
    html! {
        @for (what, value) in told {
            @if let Some(value) = words(value) { p class="settings" { b { (what) ": " } (value) } }
        }
        @if !bench.table.is_empty() { (updates(&bench.table)) }
        div class="scroll" {
            table class="sortable" {
                caption { "What was timed or counted." }
                thead { tr { th { "what" } th class="num" { "value" } th { "unit" } th { "note" } } }
                tbody { @for figure in &bench.figures { tr {
                    td { (figure.name) }
                    td class="num" data-v=(figure.value) { (sig(figure.value, 4)) }
                    td { (figure.unit) }
                    td { (figure.note) }
                } } }
            }
        }
    }
}

fn updates(table: &[Timed]) -> Markup {
    let plain = |v: Option<f64>| v.map_or(NONE.into(), |v| sig(v, 3));
    html! {
        div class="scroll tall" {
            table class="sortable" {
                caption { "Pose updates by every optimiser, and by those of other crates, on the same problems in one run. Ratio: time as a multiple of the default method's at the same budget." }
                thead { tr {
                    th { "crate" } th { "optimiser" } th class="num" { "budget" } th class="num" { "evaluations" } th class="num" { "time (µs)" } th class="num" { "ratio" }
                    th class="num" { "within 2 mm (%)" } th class="num" { "median (mm)" }
                } }
                tbody { @for row in table { tr {
                    td { (row.origin) }
                    td class="name" { (row.optimizer) }
                    td class="num" { (row.budget) }
                    td class="num" data-v=[row.evaluations_median] { (plain(row.evaluations_median)) }
                    td class="num" data-v=[row.time_median_s] { (plain(row.time_median_s.map(|s| s * 1e6))) }
                    td class="num" data-v=[row.time_to_default] { (plain(row.time_to_default)) }
                    td class="num" data-v=[row.within_2mm] { (row.within_2mm.map_or(NONE.into(), percent)) }
                    td class="num" data-v=[row.location_error_median_m] { (mm(row.location_error_median_m)) }
                } } }
            }
        }
    }
}
