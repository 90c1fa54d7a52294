//! Batches of missions: what can be known from how many touches, and what was made of it.

use super::head::KeyFigure;
use super::input::Run;
use super::number::{NONE, deg, mm, percent, quantile, share, sig};
use super::row::TrialLine;
use super::svg::{Frame, n};
use crate::experiment::observability::Class as Verdict;
use anyhow::Context;
use maud::{Markup, html};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Missions after a number of touches.
#[derive(Deserialize, Clone, Debug)]
pub struct AfterTouch {
    touches: u64,
    located: usize,
    not_observable: usize,
    wrong: usize,
    /// Missions whose evidence does not tell the pose as exactly as a grasp needs it.
    ambiguous: Option<usize>,
}

impl AfterTouch {
    fn counts(&self) -> [(Verdict, usize); 3] {
        [(Verdict::Located, self.located), (Verdict::NotObservable, self.not_observable), (Verdict::Wrong, self.wrong)]
    }

    fn total(&self) -> usize {
        self.located + self.not_observable + self.wrong
    }
}

/// A batch with its table by touch.
pub struct Batch<'a> {
    /// The files.
    pub run: &'a Run<TrialLine>,
    /// The table; empty if there is none.
    pub by_touch: Vec<AfterTouch>,
}

/// The table by touch of a file.
///
/// # Errors
/// It is not one.
pub fn by_touch(run: &Run<TrialLine>) -> anyhow::Result<Vec<AfterTouch>> {
    run.meta.statistics.get("by_touch").map_or(Ok(Vec::new()), |table| {
        Deserialize::deserialize(table).with_context(|| {
            format!("{}.json: statistics.by_touch: expected touches, located, not_observable, wrong", run.stem)
        })
    })
}

/// The class of a verdict's mark in the style sheet.
const fn css(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Located => "located",
        Verdict::NotObservable => "unseen",
        Verdict::Wrong => "wrong",
    }
}

fn count(rows: &[TrialLine], verdict: Verdict) -> usize {
    rows.iter().filter(|r| r.verdict == verdict).count()
}

/// The section.
pub fn section(batches: &[Batch<'_>]) -> Markup {
    html! {
        p {
            "Every mission had its own true pose, guess and noise. " b { "Located" } ": the belief is within 2 mm and 1° of the truth. " b { "Not observable" }
            ": it is not, but the true pose explains what was felt within its noise as well, so the evidence does not tell. " b { "Wrong" }
            ": it is not, although the evidence tells. A mission is " b { "confidently wrong" } " if the truth lies clearly outside what the controller itself believed possible."
        }
        @for batch in batches { (section_of(batch)) }
    }
}

fn section_of(Batch { run, by_touch }: &Batch<'_>) -> Markup {
    html! {
        h3 { (run.meta.title) " " span class="stem" { (run.stem) } }
        p class="settings" { (run.meta.describe()) " · file " (run.stem) ".csv" }
        @if !by_touch.is_empty() {
            div class="figures" {
                figure {
                    (bars(by_touch, &run.meta.title))
                    @let ambiguous = by_touch.iter().any(|t| t.ambiguous.is_some());
                    (legend(ambiguous))
                    figcaption {
                        "Share of missions by what is known after each touch, each bar all missions; the numbers are missions. "
                        @if ambiguous { "The brace above a bar is the share whose evidence is ambiguous. " }
                        "The next touch is chosen to tell what is not known yet: from bar to bar, these parts should vanish."
                    }
                }
                (touch_table(by_touch))
            }
        }
        div class="figures" {
            figure {
                (histogram(&run.rows, &run.meta.title))
                (legend(false))
                figcaption { "Missions by location error of the final belief; the bins are equal on the logarithmic axis, the first and the last hold all beyond. Dotted lines: 2 and 10 mm." }
            }
            (facts(&run.rows))
        }
        (wrong_table(&run.rows))
    }
}

fn legend(ambiguous: bool) -> Markup {
    html! {
        ul class="legend" {
            @for verdict in Verdict::ALL {
                li { svg viewBox="0 0 20 14" width="20" height="14" { rect class={"swatch v-" (css(verdict))} width="20" height="14" {} } (verdict.name()) }
            }
            @if ambiguous {
                li { svg viewBox="0 0 24 14" width="24" height="14" { path class="brace" d="M2 11V5H22V11" {} } "evidence ambiguous" }
            }
        }
    }
}

fn bars(table: &[AfterTouch], title: &str) -> Markup {
    const BAR: f64 = 26.0;
    const GAP: f64 = 14.0;
    let height = table.len() as f64 * (BAR + GAP) + GAP;
    let frame = Frame { left: 58.0, top: 8.0, width: 380.0, height, x: [0.0, 1.0], y: [0.0, 1.0] };
    let middle = |i: usize| GAP + i as f64 * (BAR + GAP) + BAR / 2.0;
    let ys: Vec<_> = table.iter().enumerate().map(|(i, t)| (1.0 - middle(i) / height, t.touches.to_string())).collect();
    let xs: Vec<_> = (0..=4).map(|i| (f64::from(i) * 0.25, (i * 25).to_string())).collect();
    html! {
        svg class="plot" role="img" aria-label={"Missions by what is known after each touch: " (title)} viewBox={"0 0 460 " (n(frame.bottom() + 42.0))} width="460" {
            (frame.axes(&xs, &ys, ["missions (%)", "touches"], false))
            @for (i, after) in table.iter().enumerate() { (bar(&frame, after, frame.top + middle(i) - BAR / 2.0, BAR)) }
        }
    }
}

fn bar(frame: &Frame, after: &AfterTouch, top: f64, height: f64) -> Markup {
    let mut from = 0.0;
    let parts = after.counts().map(|(verdict, count)| {
        let start = from;
        from += share(count, after.total().max(1));
        (verdict, count, start, from)
    });
    html! {
        @if let Some(count) = after.ambiguous {
            @let end = frame.px(share(count, after.total().max(1)));
            path class="brace" d={"M" (n(frame.left + 1.0)) " " (n(top - 1.0)) "v-5H" (n(end)) "v5"} {
                title { "after " (after.touches) " touches: the evidence of " (count) " is ambiguous" }
            }
        }
        @for (verdict, count, start, end) in parts {
            @let (left, width) = (frame.px(start), (end - start) * frame.width);
            @if count > 0 {
                rect class={"seg v-" (css(verdict))} x=(n(left)) y=(n(top)) width=(n(width)) height=(n(height)) {
                    title { "after " (after.touches) " touches: " (count) " " (verdict.name()) }
                }
                @if width > 26.0 {
                    text class="seg-text" text-anchor="middle" x=(n(left + width / 2.0)) y=(n(top + height / 2.0 + 4.0)) { (count) }
                }
            }
        }
    }
}

fn touch_table(table: &[AfterTouch]) -> Markup {
    let ambiguous = table.iter().any(|t| t.ambiguous.is_some());
    let cell = |count: Option<usize>, after: &AfterTouch| {
        count.map_or(NONE.into(), |n| format!("{n} ({})", percent(share(n, after.total()))))
    };
    html! {
        div class="scroll" {
            table {
                caption {
                    "Missions by what is known after each touch, and their share in %; a mission that needed fewer touches counts as it ended."
                    @if ambiguous { " Ambiguous: those whose evidence does not tell the pose as exactly as a grasp needs it, wherever the belief is." }
                }
                thead { tr {
                    th class="num" { "touches" }
                    @for verdict in Verdict::ALL { th class="num" { (verdict.name()) " (%)" } }
                    @if ambiguous { th class="num" { "ambiguous (%)" } }
                } }
                tbody { @for after in table { tr {
                    td class="num" { (after.touches) }
                    @for (_, count) in after.counts() { td class="num" { (cell(Some(count), after)) } }
                    @if ambiguous { td class="num" { (cell(after.ambiguous, after)) } }
                } } }
            }
        }
    }
}

/// Edges of the bins, millimetres: four a decade from 0.1 to 100.
fn bin(mm: f64) -> usize {
    ((mm.max(1e-9).log10() + 1.0) * 4.0).floor().clamp(0.0, 12.0) as usize
}

fn histogram(rows: &[TrialLine], title: &str) -> Markup {
    let mut bins = [[0usize; 3]; 13];
    for row in rows {
        let slot = row.location_m.map_or(12, |m| bin(m * 1e3));
        bins[slot][row.verdict as usize] += 1;
    }
    let most = bins.iter().map(|b| b.iter().sum::<usize>()).max().unwrap_or(0).max(1) as f64;
    let frame = Frame { left: 58.0, top: 10.0, width: 380.0, height: 200.0, x: [0.0, 13.0], y: [0.0, most * 1.05] };
    let place = |mm: f64| (mm.log10() + 1.0) * 4.0;
    let xs: Vec<_> = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0].iter().map(|v| (place(*v), sig(*v, 1))).collect();
    let ys: Vec<_> = frame.y_ticks(5).into_iter().filter(|(v, _)| v.fract() == 0.0).collect();
    html! {
        svg class="plot" role="img" aria-label={"Distribution of the location error: " (title)} viewBox="0 0 460 252" width="460" {
            (frame.axes(&xs, &ys, ["location error (mm)", "missions"], false))
            @for (i, parts) in bins.iter().enumerate() {
                @for (k, verdict) in Verdict::ALL.into_iter().enumerate() {
                    @let below: usize = parts[..k].iter().sum();
                    @let (top, bottom) = (frame.py((below + parts[k]) as f64), frame.py(below as f64));
                    @if parts[k] > 0 {
                        rect class={"seg v-" (css(verdict))} x=(n(frame.px(i as f64) + 1.0)) width=(n(frame.width / 13.0 - 2.0)) y=(n(top)) height=(n(bottom - top)) {
                            title { (parts[k]) " " (verdict.name()) }
                        }
                    }
                }
            }
            @for limit in [2.0, 10.0] {
                line class="limit" x1=(n(frame.px(place(limit)))) x2=(n(frame.px(place(limit)))) y1=(n(frame.top)) y2=(n(frame.bottom())) {}
            }
        }
    }
}

fn facts(rows: &[TrialLine]) -> Markup {
    let location = |p| mm(quantile(rows.iter().map(|r| r.location_m), p));
    let yaw = |p| deg(quantile(rows.iter().map(|r| r.yaw_rad), p).filter(|v| v.is_finite()));
    let both = |m: f64, rad: f64| {
        let good = |r: &&TrialLine| r.location_m.is_some_and(|v| v <= m) && r.yaw_rad.is_some_and(|v| v <= rad);
        rows.iter().filter(good).count()
    };
    let of_all = |count: usize| format!("{count} of {} ({} %)", rows.len(), percent(share(count, rows.len())));
    let mut outcomes: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows {
        *outcomes.entry(&row.outcome).or_default() += 1;
    }
    let touches = rows.iter().map(|r| r.touches as f64).sum::<f64>() / rows.len() as f64;
    let line = |name: &str, value: String| html! { tr { th { (name) } td class="num" { (value) } } };
    html! {
        table class="facts" {
            tbody {
                @for verdict in Verdict::ALL { (line(verdict.name(), of_all(count(rows, verdict)))) }
                (line("confidently wrong", of_all(rows.iter().filter(|r| r.confidently_wrong).count())))
                (line("within 1 mm", of_all(both(0.001, f64::INFINITY))))
                (line("within 2 mm and 1°", of_all(both(0.002, 1f64.to_radians()))))
                (line("location error: median, 95 %, largest", format!("{}, {}, {} mm", location(0.5), location(0.95), location(1.0))))
                (line("yaw error: median, 95 %", format!("{}°, {}°", yaw(0.5), yaw(0.95))))
                (line("touches, mean", sig(touches, 3)))
                @for (outcome, count) in outcomes { (line(&format!("outcome: {outcome}"), of_all(count))) }
            }
        }
    }
}

/// The missions that are wrong, the worst first: to be looked into one by one.
fn wrong_table(rows: &[TrialLine]) -> Markup {
    const MOST: usize = 40;
    let mut wrong: Vec<&TrialLine> =
        rows.iter().filter(|r| r.confidently_wrong || r.verdict == Verdict::Wrong).collect();
    let error = |r: &TrialLine| r.location_m.unwrap_or(f64::INFINITY);
    wrong.sort_by(|a, b| error(b).total_cmp(&error(a)));
    let all = wrong.len();
    wrong.truncate(MOST);
    html! {
        @if wrong.is_empty() { p { "No mission is wrong or confidently wrong." } }
        @else {
            div class="scroll tall" {
                table class="sortable" {
                    caption {
                        "The " @if all > MOST { (MOST) " worst of the " } (all) " missions that are wrong or confidently wrong. "
                        "“Believed” is the standard deviation that the controller thought it had."
                    }
                    thead { tr {
                        th class="num" { "seed" } th { "class" } th { "confidently wrong" } th class="num" { "off by (mm)" } th class="num" { "yaw (°)" }
                        th class="num" { "believed x (mm)" } th class="num" { "believed y (mm)" } th class="num" { "touches" } th { "outcome" }
                    } }
                    tbody { @for row in &wrong { tr {
                        td class="num" { (row.seed) }
                        td { (row.verdict.name()) }
                        td { @if row.confidently_wrong { "yes" } @else { (NONE) } }
                        td class="num" data-v=[row.location_m] { (mm(row.location_m)) }
                        td class="num" data-v=[row.yaw_rad] { (deg(row.yaw_rad)) }
                        @for sd in row.sd_m { td class="num" data-v=[sd] { (mm(sd)) } }
                        td class="num" { (row.touches) }
                        td { (row.outcome) }
                    } } }
                }
            }
        }
    }
}

/// The key figure of a batch.
pub fn key_figure(run: &Run<TrialLine>) -> KeyFigure {
    let rows = &run.rows;
    let part = |count: usize| percent(share(count, rows.len()));
    KeyFigure {
        value: format!("{} %", part(count(rows, Verdict::Located))),
        what: format!("of {} missions located the box", rows.len()),
        note: format!(
            "{} % not observable, {} % wrong, {} % confidently wrong",
            part(count(rows, Verdict::NotObservable)),
            part(count(rows, Verdict::Wrong)),
            part(rows.iter().filter(|r| r.confidently_wrong).count())
        ),
        title: run.meta.title.clone(),
        stem: run.stem.clone(),
    }
}
