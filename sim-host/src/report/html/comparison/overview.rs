//! All methods at one budget in one view: a row for each optimiser, a column for each error.

use super::Entry;
use crate::report::html::number::{NONE, mm, percent};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// The view, one part for each number of degrees of freedom.
pub fn table(entries: &[&Entry], budget: u64) -> Markup {
    let dofs: BTreeSet<u64> = entries.iter().map(|e| e.dof).collect();
    let errors: BTreeSet<&str> = entries.iter().map(|e| e.error.as_str()).collect();
    html! {
        div class="scroll" {
            table class="dense" {
                caption {
                    "Share of problems within 2 mm (%), and the median location error (mm) beside it, at a budget of " (budget) " evaluations. "
                    "★ and bold: most within 2 mm with these degrees of freedom, unless most methods share it."
                }
                thead {
                    tr { th rowspan="2" { "DOF" } th rowspan="2" { "optimiser" } @for error in &errors { th class="num" colspan="2" { (error) } } }
                    tr { @for _ in &errors { th class="num" { "within 2 mm (%)" } th class="num" { "median (mm)" } } }
                }
                @for dof in dofs {
                    @let group: Vec<&Entry> = entries.iter().filter(|e| e.dof == dof).copied().collect();
                    (part(&group, &errors))
                }
            }
        }
    }
}

fn part(group: &[&Entry], errors: &BTreeSet<&str>) -> Markup {
    let optimizers: BTreeSet<&str> = group.iter().map(|e| e.optimizer.as_str()).collect();
    let most = group.iter().map(|e| e.within_2mm).fold(0.0, f64::max);
    let sharing = group.iter().filter(|e| e.within_2mm >= most).count();
    let marked = most > 0.0 && (sharing == 1 || 2 * sharing <= group.len());
    html! {
        tbody {
            @for optimizer in optimizers {
                tr {
                    td class="num" { (group.first().map_or(0, |e| e.dof)) }
                    td class="name" { (optimizer) }
                    @for error in errors {
                        @match group.iter().find(|e| e.optimizer == optimizer && e.error == *error) {
                            Some(entry) => {
                                td class="num" {
                                    @if marked && entry.within_2mm >= most { b class="best" { "★ " (percent(entry.within_2mm)) } }
                                    @else { (percent(entry.within_2mm)) }
                                }
                                td class="num" { (mm(entry.median_m)) }
                            }
                            None => { td class="num" { (NONE) } td class="num" { (NONE) } }
                        }
                    }
                }
            }
        }
    }
}
