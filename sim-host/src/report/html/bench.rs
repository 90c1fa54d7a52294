//! Benchmarks.

use super::input::Figure;
use super::number::sig;
use maud::{Markup, html};

/// The section.
pub fn section(figures: &[Figure]) -> Markup {
    html! {
        div class="scroll" {
            table class="sortable" {
                caption { "What was timed or counted, on the machine named in the note or above." }
                thead { tr { th { "what" } th class="num" { "value" } th { "unit" } th { "note" } } }
                tbody { @for figure in figures { tr {
                    td { (figure.name) }
                    td class="num" data-v=(figure.value) { (sig(figure.value, 4)) }
                    td { (figure.unit) }
                    td { (figure.note) }
                } } }
            }
        }
    }
}
