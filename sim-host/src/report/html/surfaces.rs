//! Error surfaces: the counterpart of figure 25 of Nikandrova (2011).

use super::colour::Scale;
use super::heat::{Cell, Fill, HeatMap};
use super::input::{Meta, Run};
use super::number::{deg, mm, percent, sig};
use super::raster::{Raster, Terrain, terrain};
use super::row::SurfaceLine;
use super::svg;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The error that a surface shows.
fn error_name(meta: &Meta) -> String {
    meta.setting("error").unwrap_or_else(|| "error".into())
}

/// One scale for all surfaces of the same error, so that they can be compared.
fn scales(runs: &[Run<SurfaceLine>]) -> BTreeMap<String, Scale> {
    let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for run in runs {
        let known = run.rows.iter().filter_map(|r| r.error.as_ref().ok());
        values.entry(error_name(&run.meta)).or_default().extend(known);
    }
    values.into_iter().map(|(name, values)| (name, Scale::fit(&values))).collect()
}

/// The section.
pub fn section(runs: &[Run<SurfaceLine>]) -> Markup {
    let scales = scales(runs);
    html! {
        p {
            "The error over a grid of hypothesised poses, with the rest of the pose at its true value: the landscape in which an optimiser searches. "
            "It should fall towards the true pose from everywhere; flat parts give no direction, and every further minimum is a trap. "
            "Nikandrova (2011, fig. 25) found for the weighted error flat areas, many minima and the value zero over a whole range of poses, "
            "and for the modified error one global minimum with local minima left."
        }
        div class="figures" {
            @for run in runs { (surface(run, &scales[&error_name(&run.meta)])) }
        }
        (table(runs))
    }
}

/// One slice of a surface.
struct Slice<'a> {
    cells: Vec<Option<&'a SurfaceLine>>,
    terrain: Terrain,
    lowest: Vec<(usize, usize)>,
}

fn slice<'a>(raster: &Raster, phi: usize, rows: &'a [SurfaceLine]) -> Slice<'a> {
    let width = raster.x.values.len();
    let cells = raster.slice(phi, rows, |r| r.at);
    let values: Vec<Option<f64>> = cells.iter().map(|c| c.and_then(|c| c.error.as_ref().ok().copied())).collect();
    let least = values.iter().flatten().copied().reduce(f64::min);
    let lowest = (0..values.len()).filter(|i| values[*i].is_some() && values[*i] == least);
    let lowest = lowest.map(|i| (i % width, i / width)).collect();
    Slice { terrain: terrain(&values, width), cells, lowest }
}

/// Reasons for poses without a value, the most frequent first, with their numbers.
fn reasons(rows: &[SurfaceLine]) -> Vec<(&str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for reason in rows.iter().filter_map(|r| r.error.as_ref().err()) {
        *counts.entry(reason).or_default() += 1;
    }
    let mut all: Vec<_> = counts.into_iter().collect();
    all.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    all
}

fn surface(run: &Run<SurfaceLine>, scale: &Scale) -> Markup {
    let raster = Raster::of(run.rows.iter().map(|r| r.at), run.meta.grid.as_ref());
    let reasons = reasons(&run.rows);
    let many = raster.phi.values.len() > 1;
    html! {
        figure class=[many.then_some("wide")] {
            h3 { (run.meta.title) " " span class="stem" { (run.stem) } }
            div class=[many.then_some("multiples")] {
                @for (i, phi) in raster.phi.values.iter().enumerate() {
                    div {
                        @if many { p class="multiple" { "φ = " (deg(Some(*phi))) "°" } }
                        (draw(run, &raster, i, scale, &reasons))
                    }
                }
            }
            (legend(&reasons, run.meta.truth.is_some()))
            figcaption {
                "Colour: error " b { (error_name(&run.meta)) } ", scale " (scale.note())
                ", the same on every surface of this error. "
                "Dark = small. The ring with the cross is the true pose; diamonds mark the smallest error on the grid, wherever it occurs. "
                span class="settings" { (run.meta.describe()) " · file " (run.stem) ".csv" }
            }
        }
    }
}

fn draw(run: &Run<SurfaceLine>, raster: &Raster, phi: usize, scale: &Scale, reasons: &[(&str, usize)]) -> Markup {
    let slice = slice(raster, phi, &run.rows);
    let width = raster.x.values.len();
    let cell = |(i, line): (usize, &&SurfaceLine)| {
        let place = format!("x {} m, y {} m", sig(line.at.x, 4), sig(line.at.y, 4));
        let (fill, what) = match &line.error {
            Ok(v) => (Fill::Colour(scale.colour(*v)), format!("error {}", sig(*v, 4))),
            Err(reason) => {
                (Fill::Hatch(reasons.iter().position(|(r, _)| r == reason).unwrap_or(0)), reason.to_string())
            }
        };
        Cell { ix: i % width, iy: i / width, fill, tip: format!("{place}: {what}") }
    };
    let cells = slice.cells.iter().enumerate().filter_map(|(i, c)| c.as_ref().map(|c| cell((i, c)))).collect();
    HeatMap {
        raster,
        cells,
        truth: run.meta.truth,
        lowest: slice.lowest,
        bar: Some((scale, "error")),
        heading: String::new(),
        label: format!("Heat map: {}", run.meta.title),
        width: if raster.phi.values.len() > 1 { 220.0 } else { 360.0 },
    }
    .draw()
}

fn legend(reasons: &[(&str, usize)], truth: bool) -> Markup {
    html! {
        ul class="legend" {
            @if truth { li { svg viewBox="-12 -12 24 24" width="20" height="20" { (svg::truth_mark(0.0, 0.0)) } "true pose" } }
            li { svg viewBox="-12 -12 24 24" width="20" height="20" { (svg::lowest_mark(0.0, 0.0, 6.0)) } "smallest error" }
            @for (i, (reason, count)) in reasons.iter().enumerate() {
                li {
                    svg viewBox="0 0 20 14" width="20" height="14" { rect class="swatch" width="20" height="14" fill=(svg::hatch(i)) {} }
                    "no value: " (reason) " (" (count) ")"
                }
            }
        }
    }
}

fn table(runs: &[Run<SurfaceLine>]) -> Markup {
    html! {
        div class="scroll" {
            table class="sortable" {
                caption {
                    "What the surfaces mean for a search. Minima: places on the grid (a cell, or a plain of equal cells) from which every step along x or y leads up. "
                    "Flat along x or y: poses whose neighbours there have the same error, so that a difference quotient says nothing."
                }
                thead { tr {
                    th { "surface" } th class="num" { "φ (°)" } th class="num" { "poses" } th class="num" { "without value" }
                    th class="num" { "smallest error" } th class="num" { "largest error" } th class="num" { "poses with the smallest" } th class="num" { "minima" } th class="num" { "flat along x (%)" } th class="num" { "flat along y (%)" }
                    th class="num" { "smallest lie up to (mm) off the truth" }
                } }
                tbody {
                    @for run in runs {
                        @let raster = Raster::of(run.rows.iter().map(|r| r.at), run.meta.grid.as_ref());
                        @for (i, phi) in raster.phi.values.iter().enumerate() { (table_row(run, &raster, i, *phi)) }
                    }
                }
            }
        }
    }
}

fn table_row(run: &Run<SurfaceLine>, raster: &Raster, i: usize, phi: f64) -> Markup {
    let slice = slice(raster, i, &run.rows);
    let lines: Vec<&SurfaceLine> = slice.cells.iter().flatten().copied().collect();
    let values: Vec<f64> = lines.iter().filter_map(|l| l.error.as_ref().ok().copied()).collect();
    let low = values.iter().copied().reduce(f64::min);
    let high = values.iter().copied().reduce(f64::max);
    let distance = |(ix, iy): &(usize, usize)| {
        run.meta.truth.map(|t| (raster.x.values[*ix] - t.x).hypot(raster.y.values[*iy] - t.y))
    };
    let off = slice.lowest.iter().filter_map(distance).reduce(f64::max);
    // Nearer than a micrometre is single precision, not a distance.
    let off = off.map(|m| if m < 1e-6 { 0.0 } else { m });
    let shown = |v: Option<f64>| v.map_or(super::number::NONE.to_string(), |v| sig(v, 3));
    html! {
        tr {
            td class="name" { (run.stem) }
            td class="num" { (deg(Some(phi))) }
            td class="num" { (lines.len()) }
            td class="num" { (lines.len() - values.len()) }
            td class="num" data-v=[low] { (shown(low)) }
            td class="num" data-v=[high] { (shown(high)) }
            td class="num" { (slice.lowest.len()) }
            td class="num" { (slice.terrain.minima) }
            @for flat in slice.terrain.flat { td class="num" { (percent(flat)) } }
            td class="num" data-v=[off] { (mm(off)) }
        }
    }
}
