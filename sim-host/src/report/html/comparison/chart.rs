//! Charts of a comparison: share within 2 mm against the budget, and how location errors are distributed.

use super::{Entry, by_method};
use crate::report::html::input::Run;
use crate::report::html::number::sig;
use crate::report::html::row::CompareLine;
use crate::report::html::svg::{self, Frame, SERIES, dashes, n};
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// Left edge of the distribution, millimetres: nearer is near enough.
const NEAR_MM: f64 = 0.1;
/// Right edge, millimetres.
const FAR_MM: f64 = 300.0;

/// The optimiser that is used where none is named; its line is heavier.
const DEFAULT: &str = "levenberg-marquardt";

fn weight(name: &str) -> &'static str {
    if name == DEFAULT { " default" } else { "" }
}

fn dash(name: &str, look: usize) -> &'static str {
    if name == DEFAULT { "none" } else { dashes(look) }
}

/// The look of every optimiser, the same in all charts.
type Looks<'a> = BTreeMap<&'a str, usize>;

/// A row of two charts for every error and number of degrees of freedom.
pub fn charts(run: &Run<CompareLine>, entries: &[Entry], budget: u64) -> Markup {
    let names: BTreeSet<&str> = entries.iter().map(|e| e.optimizer.as_str()).collect();
    let looks: Looks<'_> = names.into_iter().enumerate().map(|(i, name)| (name, i)).collect();
    let panels: BTreeSet<(u64, &str)> = entries.iter().map(|e| (e.dof, e.error.as_str())).collect();
    let budgets: BTreeSet<u64> = entries.iter().map(|e| e.budget).collect();
    html! {
        @for (i, (dof, error)) in panels.into_iter().enumerate() {
            @let here: Vec<&Entry> = entries.iter().filter(|e| e.dof == dof && e.error == error).collect();
            figure class="wide" {
                h4 { (dof) "-DOF, error " (error) }
                div class="pair" {
                    @if budgets.len() > 1 { (against_budget(&here, &budgets, &looks, &format!("{dof}-DOF, error {error}"))) }
                    (distribution(run, (dof, error, budget), &looks))
                }
                (key(&looks))
                figcaption { @if i > 0 { (dof) "-DOF, error " (error) "; to be read as the first chart of this comparison." } @else {
                    @if budgets.len() > 1 { "Left: share of problems within 2 mm against the budget of evaluations; higher and further left is better. Right: s" } @else { "S" }
                    "hare of problems whose location error is at most the value below, at " (budget) " evaluations; the marks stand at the median and the 90th percentile. "
                    "The heavy line is the default optimiser. A line that rises early and reaches 100 % is good; where it ends below, the rest is off by more than " (sig(FAR_MM, 3)) " mm or has no answer."
                } }
            }
        }
    }
}

fn key(looks: &Looks<'_>) -> Markup {
    html! {
        ul class="legend" {
            @for (name, look) in looks {
                li {
                    svg viewBox="0 0 36 14" width="36" height="14" {
                        line class={"line s" (look % SERIES) (weight(name))} stroke-dasharray=(dash(name, *look)) x1="0" x2="36" y1="7" y2="7" {}
                        (svg::marker(*look, 18.0, 7.0))
                    }
                    (name)
                }
            }
        }
    }
}

fn shares() -> Vec<(f64, String)> {
    (0..=5).map(|i| (f64::from(i) * 0.2, (i * 20).to_string())).collect()
}

fn path(frame: &Frame, points: &[(f64, f64)]) -> String {
    let joined: Vec<String> = points.iter().map(|(x, y)| format!("{} {}", n(frame.px(*x)), n(frame.py(*y)))).collect();
    format!("M{}", joined.join("L"))
}

fn against_budget(entries: &[&Entry], budgets: &BTreeSet<u64>, looks: &Looks<'_>, label: &str) -> Markup {
    let log = |budget: u64| (budget.max(1) as f64).log10();
    let (low, high) = (budgets.first().copied().unwrap_or(1), budgets.last().copied().unwrap_or(10));
    let frame = Frame {
        left: 52.0,
        top: 12.0,
        width: 270.0,
        height: 230.0,
        x: [log(low) - 0.05, log(high) + 0.05],
        y: [0.0, 1.02],
    };
    let mut lines: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for entry in entries {
        lines.entry(&entry.optimizer).or_default().push((log(entry.budget), entry.within_2mm));
    }
    let xs: Vec<_> = budgets.iter().map(|b| (log(*b), b.to_string())).collect();
    let ends = lines.iter().filter_map(|(name, points)| points.last().map(|(_, y)| (*name, frame.py(*y)))).collect();
    html! {
        svg class="plot" role="img" aria-label={"Share within 2 mm against budget: " (label)} viewBox="0 0 516 282" width="516" {
            (frame.axes(&xs, &shares(), ["budget (evaluations)", "within 2 mm (%)"], true))
            @for (name, points) in &lines {
                @let look = looks[name];
                path class={"line s" (look % SERIES) (weight(name))} stroke-dasharray=(dash(name, look)) d=(path(&frame, points)) { title { (name) } }
                @for (x, y) in points { (svg::marker(look, frame.px(*x), frame.py(*y))) }
            }
            @for (name, from, to) in spread(ends, frame.top + 4.0, frame.bottom()) {
                path class="leader" d={"M" (n(frame.right() + 2.0)) " " (n(from)) "L" (n(frame.right() + 12.0)) " " (n(to))} {}
                text class={"direct t" (looks[name] % SERIES) (weight(name))} x=(n(frame.right() + 15.0)) y=(n(to + 3.5)) { (name) }
            }
        }
    }
}

/// Moves labels apart: (name, where it belongs, where it goes).
fn spread(mut labels: Vec<(&str, f64)>, top: f64, bottom: f64) -> Vec<(&str, f64, f64)> {
    const LINE: f64 = 13.0;
    labels.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut placed: Vec<(&str, f64, f64)> = Vec::new();
    for (name, y) in labels {
        let least = placed.last().map_or(top, |(_, _, to)| to + LINE);
        placed.push((name, y, y.max(least)));
    }
    // What was pushed over the lower edge goes back up, and pushes in turn.
    let mut limit = bottom;
    for (_, _, to) in placed.iter_mut().rev() {
        *to = to.min(limit);
        limit = *to - LINE;
    }
    placed
}

fn distribution(run: &Run<CompareLine>, (dof, error, budget): (u64, &str, u64), looks: &Looks<'_>) -> Markup {
    let log = |mm: f64| mm.max(NEAR_MM).log10();
    let frame =
        Frame { left: 52.0, top: 12.0, width: 380.0, height: 230.0, x: [log(NEAR_MM), log(FAR_MM)], y: [0.0, 1.02] };
    let methods = by_method(&run.rows);
    let xs: Vec<_> = [0.1, 0.3, 1.0, 2.0, 10.0, 30.0, 100.0, 300.0].iter().map(|v| (log(*v), sig(*v, 2))).collect();
    html! {
        svg class="plot" role="img" aria-label={"Distribution of location error: " (dof) "-DOF, error " (error)} viewBox="0 0 446 282" width="446" {
            (frame.axes(&xs, &shares(), ["location error (mm)", "at most that (%)"], true))
            @for limit in [2.0, 10.0] {
                line class="limit" x1=(n(frame.px(log(limit)))) x2=(n(frame.px(log(limit)))) y1=(n(frame.top)) y2=(n(frame.bottom())) {}
            }
            @for (name, look) in looks {
                @if let Some(rows) = methods.get(&(dof, budget, error, *name)) {
                    @let steps = steps(rows);
                    path class={"line s" (look % SERIES) (weight(name))} stroke-dasharray=(dash(name, *look))
                        d=(path(&frame, &steps.iter().map(|(mm, y)| (log(*mm), *y)).collect::<Vec<_>>())) { title { (name) } }
                    @for p in [0.5, 0.9] {
                        @if let Some((mm, _)) = steps.iter().find(|(_, y)| *y >= p - 1e-9) {
                            (svg::marker(*look, frame.px(log(*mm)), frame.py(p)))
                        }
                    }
                }
            }
        }
    }
}

/// The empirical distribution as corners of a staircase: (millimetres, share), thinned to what a screen shows.
fn steps(rows: &[&CompareLine]) -> Vec<(f64, f64)> {
    let mut errors: Vec<f64> =
        rows.iter().filter_map(|r| r.location_m).map(|m| m * 1e3).filter(|v| *v <= FAR_MM).collect();
    errors.sort_by(f64::total_cmp);
    let every = errors.len().div_ceil(200).max(1);
    let mut corners = vec![(NEAR_MM, 0.0)];
    let mut height = 0.0;
    for (i, mm) in errors.iter().enumerate() {
        if (i + 1) % every == 0 || i + 1 == errors.len() {
            corners.push((*mm, height));
            height = (i + 1) as f64 / rows.len() as f64;
            corners.push((*mm, height));
        }
    }
    corners.push((FAR_MM, height));
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_never_overlap() {
        let labels = vec![("a", 10.0), ("b", 11.0), ("c", 99.0), ("d", 100.0), ("e", 100.0)];
        let placed = spread(labels, 0.0, 100.0);
        assert!(placed.windows(2).all(|w| w[1].2 - w[0].2 >= 13.0 - 1e-9), "{placed:?}");
        assert!(placed.iter().all(|p| p.2 <= 100.0));
    }
}
