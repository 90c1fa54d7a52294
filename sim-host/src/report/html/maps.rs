//! Maps of convergence: the counterpart of figure 26 of Nikandrova (2011).

use super::colour::Scale;
use super::head::KeyFigure;
use super::heat::{Cell, Fill, HeatMap};
use super::input::{Run, Truth};
use super::number::{NONE, deg, duration, fixed, mm, percent, quantile, share, sig};
use super::raster::Raster;
use super::row::ConvergeLine;
use super::svg;
use crate::experiment::converge::Class;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// A class's look as the thesis draws it.
const fn look(class: Class) -> &'static str {
    match class {
        Class::Converged => "white",
        Class::Direction => "grey",
        Class::Failed => "black",
    }
}

/// What the lines of a map add up to.
pub struct Figures {
    /// Starts.
    pub starts: usize,
    /// Starts of each class, in the order of [`Class::ALL`].
    pub counts: [usize; 3],
    /// Median location error, metres.
    pub median_m: Option<f64>,
    /// 90th percentile of the location error, metres.
    pub p90_m: Option<f64>,
    /// Largest location error, metres.
    pub max_m: Option<f64>,
    /// Evaluations per start.
    pub evaluations: Option<f64>,
    /// Time of the optimiser for all starts, seconds.
    pub optimiser_s: Option<f64>,
    /// Time of gathering the evidence for all starts, seconds.
    pub evidence_s: Option<f64>,
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
    (count > 0).then(|| sum / count as f64)
}

impl Figures {
    /// Of one file; times that its lines do not have come from its JSON.
    pub fn of(run: &Run<ConvergeLine>) -> Self {
        let rows = &run.rows;
        let location = |p| quantile(rows.iter().map(|r| r.location_m), p);
        let times: f64 = rows.iter().filter_map(|r| r.time_s).sum();
        Self {
            starts: rows.len(),
            counts: Class::ALL.map(|class| rows.iter().filter(|r| r.class == class).count()),
            median_m: location(0.5),
            p90_m: location(0.9),
            max_m: location(1.0),
            evaluations: mean(rows.iter().filter_map(|r| r.evaluations)),
            optimiser_s: run.meta.statistic("optimiser_time_s").or((times > 0.0).then_some(times)),
            evidence_s: run.meta.statistic("evidence_time_s"),
        }
    }
}

/// The section.
pub fn section(runs: &[Run<ConvergeLine>]) -> Markup {
    let errors_mm: Vec<f64> =
        runs.iter().flat_map(|r| r.rows.iter().filter_map(|l| l.location_m)).map(|m| m * 1e3).collect();
    let scale = Scale::location(&errors_mm);
    html! {
        p {
            "One cell for every start: the optimiser began there, with evidence from touches planned for that guess. "
            "White: it converged (final error below the threshold). Grey: it did not, but it moved towards the truth. Black: not even that. "
            "The colours of the second map say how far from the truth it ended."
        }
        aside class="thesis" {
            b { "The thesis beside it (Nikandrova 2011, fig. 26). " }
            "Modified error, steepest descent: stable for x from 0.14 to 0.26 m for all y tried, so a basin of about ±0.05 m in x around the true 0.2 m; "
            "remaining location error up to 10 mm, usually precise along one direction only; 15–25 minutes per start."
        }
        (overview(runs))
        @for (i, run) in runs.iter().enumerate() { (map(run, &scale, i)) }
    }
}

fn overview(runs: &[Run<ConvergeLine>]) -> Markup {
    html! {
        div class="scroll" {
            table class="sortable dense" {
                caption { "All maps. Location error: distance of the end of the search from the true place; quantiles by nearest rank over all starts. Direction: not converged, but moved towards the truth. Evaluations: mean per start. Time: the optimiser's, all starts." }
                thead { tr {
                    th class="title" { "map" } th { "error" } th { "optimiser" } th { "noise" } th class="num" { "DOF" } th class="num" { "starts" }
                    (class_heads())
                    th class="num" { "median (mm)" } th class="num" { "90 % (mm)" } th class="num" { "largest (mm)" }
                    th class="num" { "evaluations" } th class="num" { "time (s)" }
                } }
                tbody {
                    @for (i, run) in runs.iter().enumerate() {
                        tr {
                            td { a href={"#map-" (i)} { (run.stem) } }
                            td { (run.meta.setting("error").unwrap_or(NONE.into())) @if let Some(how) = run.meta.setting("formulation") { ", " (how) } }
                            @for key in ["optimizer", "noise"] { td { (run.meta.setting(key).unwrap_or(NONE.into())) } }
                            td class="num" { (run.meta.setting("dof").unwrap_or(NONE.into())) }
                            (figure_cells(&Figures::of(run)))
                        }
                    }
                }
            }
        }
    }
}

/// Heads of the columns of the classes.
pub fn class_heads() -> Markup {
    html! { @for class in Class::ALL { th class="num" { (class.name()) " (%)" } } }
}

/// Cells: starts, shares of the classes, location error, evaluations, time.
pub fn figure_cells(f: &Figures) -> Markup {
    html! {
        td class="num" { (f.starts) }
        @for count in f.counts { td class="num" data-v=(share(count, f.starts)) { (percent(share(count, f.starts))) } }
        @for v in [f.median_m, f.p90_m, f.max_m] { td class="num" data-v=[v] { (mm(v)) } }
        @for v in [f.evaluations, f.optimiser_s] { td class="num" data-v=[v] { (v.map_or(NONE.into(), |v| sig(v, 3))) } }
    }
}

fn map(run: &Run<ConvergeLine>, scale: &Scale, index: usize) -> Markup {
    let raster = Raster::of(run.rows.iter().map(|r| r.at), run.meta.grid.as_ref());
    let many = raster.phi.values.len() > 1;
    let slices = || raster.phi.values.iter().enumerate();
    html! {
        figure class="wide" id={"map-" (index)} {
            h3 { (run.meta.title) " " span class="stem" { (run.stem) } }
            @if many {
                p class="multiple-head" { "Classes, one map for each φ of the start, and how many converged" }
                div class="multiples" { @for (i, phi) in slices() {
                    div { p class="multiple" { "φ = " (deg(Some(*phi))) "°, " (converged_in(&raster, i, run)) } (draw(run, &raster, i, None)) }
                } }
                p class="multiple-head" { "Final location error" }
                div class="multiples" { @for (i, phi) in slices() {
                    div { p class="multiple" { "φ = " (deg(Some(*phi))) "°" } (draw(run, &raster, i, Some(scale))) }
                }
                }
            }
            div class="map-row" {
                div {
                    @if !many { div class="pair" { (draw(run, &raster, 0, None)) (draw(run, &raster, 0, Some(scale))) } }
                    (legend(run.meta.truth))
                    (caption(run, scale, many))
                }
                (counts(run, &raster))
            }
        }
    }
}

fn caption(run: &Run<ConvergeLine>, scale: &Scale, many: bool) -> Markup {
    let stops: Vec<String> = stops(&run.rows).into_iter().map(|(reason, count)| format!("{reason} {count}")).collect();
    html! {
            figcaption {
                @if many { "Above" } @else { "Left" } ": the class of every start, as the thesis draws it. "
                @if many { "Below" } @else { "Beside it" } ": the location error where the search ended, in mm, bright = near the truth, scale "
                (scale.note()) ", the same on every map. "
                @if !stops.is_empty() { "Searches stopped because of: " (stops.join(", ")) ". " }
                span class="settings" { (run.meta.describe()) " · file " (run.stem) ".csv" }
            }
    }
}

fn converged_in(raster: &Raster, phi: usize, run: &Run<ConvergeLine>) -> String {
    let cells = raster.slice(phi, &run.rows, |r| r.at);
    let all = cells.iter().flatten().count();
    let good = cells.iter().flatten().filter(|c| c.class == Class::Converged).count();
    format!("{good} of {all}")
}

fn tip(line: &ConvergeLine) -> String {
    let plain = |v: Option<f64>| v.map_or(NONE.to_string(), |v| sig(v, 3));
    format!(
        "start x {} m, y {} m, φ {}°: {}; off by {} mm, {}°; final error {}; {} evaluations, {}; stopped: {}",
        sig(line.at.x, 4),
        sig(line.at.y, 4),
        deg(Some(line.at.phi)),
        line.class.name(),
        mm(line.location_m),
        deg(line.yaw_rad),
        plain(line.final_error),
        plain(line.evaluations),
        line.time_s.map_or(NONE.to_string(), duration),
        line.stop_reason
    )
}

/// The map of classes, or of location errors if there is a scale for them.
fn draw(run: &Run<ConvergeLine>, raster: &Raster, phi: usize, scale: Option<&Scale>) -> Markup {
    let width = raster.x.values.len();
    let cells = raster.slice(phi, &run.rows, |r| r.at);
    let cell = |i: usize, line: &ConvergeLine| {
        let fill = match (scale, line.location_m) {
            (None, _) => Fill::Class(look(line.class)),
            (Some(scale), Some(m)) => Fill::Colour(scale.colour(m * 1e3)),
            (Some(_), None) => Fill::Hatch(0),
        };
        Cell { ix: i % width, iy: i / width, fill, tip: tip(line) }
    };
    let many = raster.phi.values.len() > 1;
    let what = if scale.is_some() { "location error" } else { "classes" };
    HeatMap {
        raster,
        cells: cells.iter().enumerate().filter_map(|(i, c)| c.map(|c| cell(i, c))).collect(),
        truth: run.meta.truth,
        lowest: Vec::new(),
        bar: scale.filter(|_| phi + 1 == raster.phi.values.len()).map(|s| (s, "mm")),
        heading: match (many, scale) {
            (true, _) => String::new(),
            (_, None) => "class of every start".into(),
            (_, Some(_)) => "final location error".into(),
        },
        label: format!("Map of convergence, {what}: {}", run.meta.title),
        width: if many { 115.0 } else { 253.0 },
    }
    .draw()
}

fn legend(truth: Option<Truth>) -> Markup {
    html! {
        ul class="legend" {
            @for class in Class::ALL {
                li { svg viewBox="0 0 20 14" width="20" height="14" { rect class={"swatch " (look(class))} width="20" height="14" {} } (class.name()) }
            }
            @if let Some(t) = truth {
                li {
                    svg viewBox="-12 -12 24 24" width="20" height="20" { (svg::truth_mark(0.0, 0.0)) }
                    "true pose (x " (sig(t.x, 3)) " m, y " (sig(t.y, 3)) " m, φ " (deg(Some(t.phi))) "°)"
                }
            }
        }
    }
}

fn counts(run: &Run<ConvergeLine>, raster: &Raster) -> Markup {
    let f = Figures::of(run);
    let per_start = f.optimiser_s.map(|s| s / f.starts as f64);
    let line = |name: &str, value: String| html! { tr { th { (name) } td class="num" { (value) } } };
    let in_mm = |v: Option<f64>| if v.is_some_and(f64::is_finite) { format!("{} mm", mm(v)) } else { mm(v) };
    html! {
        table class="facts" {
            tbody {
                (line("starts", f.starts.to_string()))
                @for (class, count) in Class::ALL.into_iter().zip(f.counts) {
                    (line(class.name(), format!("{count} ({} %)", percent(share(count, f.starts)))))
                }
                (line("all converge for x in", basin(run, raster)))
                (line("location error, median", in_mm(f.median_m)))
                (line("location error, 90 %", in_mm(f.p90_m)))
                (line("location error, largest", in_mm(f.max_m)))
                @if let Some(v) = f.evaluations { (line("evaluations per start", sig(v, 3))) }
                @if let Some(v) = per_start { (line("optimiser per start", duration(v))) }
                @if let Some(v) = f.optimiser_s { (line("optimiser, all starts", duration(v))) }
                @if let Some(v) = f.evidence_s { (line("evidence, all starts", duration(v))) }
            }
        }
    }
}

/// The widest range of x around the truth in which every start converged.
fn basin(run: &Run<ConvergeLine>, raster: &Raster) -> String {
    let Some(truth) = run.meta.truth else { return NONE.into() };
    let xs = &raster.x.values;
    let mut whole = vec![true; xs.len()];
    for line in run.rows.iter().filter(|l| l.class != Class::Converged) {
        if let Some(i) = raster.x.index(line.at.x) {
            whole[i] = false;
        }
    }
    let distance = |i: &usize| (xs[*i] - truth.x).abs();
    let Some(centre) = (0..xs.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).filter(|i| whole[*i]) else {
        return "nowhere".into();
    };
    let first = (0..=centre).rev().take_while(|i| whole[*i]).last().unwrap_or(centre);
    let last = (centre..xs.len()).take_while(|i| whole[*i]).last().unwrap_or(centre);
    if first == 0 && last + 1 == xs.len() {
        return "all tried".into();
    }
    format!("{} to {} m", fixed(xs[first], 2), fixed(xs[last], 2))
}

/// Why searches stopped, the most frequent first, a few of them.
fn stops(rows: &[ConvergeLine]) -> Vec<(&str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows.iter().filter(|r| !r.stop_reason.is_empty()) {
        *counts.entry(&row.stop_reason).or_default() += 1;
    }
    let mut all: Vec<_> = counts.into_iter().collect();
    all.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    all.truncate(6);
    all
}

/// The key figure of a map.
pub fn key_figure(run: &Run<ConvergeLine>) -> KeyFigure {
    let f = Figures::of(run);
    KeyFigure {
        value: format!("{} of {}", f.counts[0], f.starts),
        what: "starts converged".into(),
        note: format!("location error: median {} mm, largest {} mm", mm(f.median_m), mm(f.max_m)),
        title: run.meta.title.clone(),
        stem: run.stem.clone(),
    }
}
