//! Parts of drawings: frames with axes, colour bars, hatches, marks.

use super::colour::Scale;
use super::number::{fixed, ticks};
use maud::{Markup, html};

/// A coordinate with as many digits as an eye can see.
pub fn n(v: f64) -> String {
    let text = format!("{v:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_string)
}

/// The plotted area of a drawing, pixels, and the ranges of its axes.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
    /// Range of x, left to right.
    pub x: [f64; 2],
    /// Range of y, bottom to top.
    pub y: [f64; 2],
}

impl Frame {
    /// Pixel of `x`.
    pub fn px(&self, x: f64) -> f64 {
        self.left + (x - self.x[0]) / (self.x[1] - self.x[0]) * self.width
    }

    /// Pixel of `y`.
    pub fn py(&self, y: f64) -> f64 {
        self.top + (self.y[1] - y) / (self.y[1] - self.y[0]) * self.height
    }

    /// Right edge.
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Lower edge.
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Border, ticks at `xs` and `ys` (value, text), names of the axes. With `grid`, lines across.
    pub fn axes(&self, xs: &[(f64, String)], ys: &[(f64, String)], names: [&str; 2], grid: bool) -> Markup {
        let (right, bottom) = (self.right(), self.bottom());
        let middle = self.top + self.height / 2.0;
        html! {
            @if grid {
                g class="grid" {
                    @for (x, _) in xs { line x1=(n(self.px(*x))) x2=(n(self.px(*x))) y1=(n(self.top)) y2=(n(bottom)) {} }
                    @for (y, _) in ys { line x1=(n(self.left)) x2=(n(right)) y1=(n(self.py(*y))) y2=(n(self.py(*y))) {} }
                }
            }
            rect class="frame" x=(n(self.left)) y=(n(self.top)) width=(n(self.width)) height=(n(self.height)) {}
            g class="tick" text-anchor="middle" {
                @for (x, text) in xs {
                    line x1=(n(self.px(*x))) x2=(n(self.px(*x))) y1=(n(bottom)) y2=(n(bottom + 4.0)) {}
                    text x=(n(self.px(*x))) y=(n(bottom + 16.0)) { (text) }
                }
            }
            g class="tick" text-anchor="end" {
                @for (y, text) in ys {
                    line x1=(n(self.left - 4.0)) x2=(n(self.left)) y1=(n(self.py(*y))) y2=(n(self.py(*y))) {}
                    text x=(n(self.left - 7.0)) y=(n(self.py(*y) + 3.5)) { (text) }
                }
            }
            text class="axis" text-anchor="middle" x=(n(self.left + self.width / 2.0)) y=(n(bottom + 33.0)) { (names[0]) }
            text class="axis" text-anchor="middle" transform={"translate(" (n(self.left - 44.0)) " " (n(middle)) ") rotate(-90)"} { (names[1]) }
        }
    }

    /// Round values along x.
    pub fn x_ticks(&self, count: usize) -> Vec<(f64, String)> {
        labelled(self.x, count)
    }

    /// Round values along y.
    pub fn y_ticks(&self, count: usize) -> Vec<(f64, String)> {
        labelled(self.y, count)
    }
}

fn labelled([low, high]: [f64; 2], count: usize) -> Vec<(f64, String)> {
    let (values, decimals) = ticks(low, high, count);
    values.into_iter().map(|v| (v, fixed(v, decimals))).collect()
}

/// An upright colour bar with numbers; `name` stands above it.
pub fn colour_bar(scale: &Scale, left: f64, top: f64, height: f64, name: &str) -> Markup {
    const WIDTH: f64 = 12.0;
    const BANDS: usize = 48;
    let band = height / BANDS as f64;
    html! {
        text class="axis" x=(n(left)) y=(n(top - 7.0)) { (name) }
        g shape-rendering="crispEdges" {
            @for i in 0..BANDS {
                rect x=(n(left)) y=(n(top + height - (i + 1) as f64 * band)) width=(n(WIDTH)) height=(n(band + 0.5))
                    fill=(scale.colour_at((i as f64 + 0.5) / BANDS as f64)) {}
            }
        }
        rect class="frame" x=(n(left)) y=(n(top)) width=(n(WIDTH)) height=(n(height)) {}
        g class="tick" {
            @for (value, text) in scale.ticks() {
                @let y = top + height * (1.0 - scale.place(value));
                line x1=(n(left + WIDTH)) x2=(n(left + WIDTH + 4.0)) y1=(n(y)) y2=(n(y)) {}
                text x=(n(left + WIDTH + 7.0)) y=(n(y + 3.5)) { (text) }
            }
        }
    }
}

/// How many hatches there are.
pub const HATCHES: usize = 5;

/// The fill of the hatch `i` (they repeat after [`HATCHES`]).
pub fn hatch(i: usize) -> String {
    format!("url(#hatch{})", i % HATCHES)
}

/// The hatches, once a page.
pub fn hatches() -> Markup {
    let lines =
        ["M0 7L7 0M-2 2L2 -2M5 9L9 5", "M0 0L7 7M-2 5L2 9M5 -2L9 2", "M0 0L7 7M0 7L7 0", "M0 3.5H7", "M3.5 0V7"];
    html! {
        svg class="defs" width="0" height="0" aria-hidden="true" {
            defs {
                @for (i, path) in lines.iter().enumerate() {
                    pattern id={"hatch" (i)} width="7" height="7" patternUnits="userSpaceOnUse" {
                        rect class="hatch-paper" width="7" height="7" {}
                        path class="hatch-line" d=(path) {}
                    }
                }
                pattern id="unseen" width="6" height="6" patternUnits="userSpaceOnUse" {
                    rect class="unseen-paper" width="6" height="6" {}
                    path class="unseen-line" d="M0 6L6 0M-2 2L2 -2M4 8L8 4" {}
                }
                pattern id="wrong" width="6" height="6" patternUnits="userSpaceOnUse" {
                    rect class="wrong-paper" width="6" height="6" {}
                    circle class="wrong-dot" cx="3" cy="3" r="1.1" {}
                }
            }
        }
    }
}

/// The true pose: a ring with a cross, dark on light on dark, so that it shows on any colour.
pub fn truth_mark(x: f64, y: f64) -> Markup {
    let cross = format!("M{} {}h18M{} {}v18", n(x - 9.0), n(y), n(x), n(y - 9.0));
    html! {
        g class="truth" {
            title { "true pose" }
            circle class="under" cx=(n(x)) cy=(n(y)) r="5.5" {}
            path class="under" d=(cross) {}
            circle class="over" cx=(n(x)) cy=(n(y)) r="5.5" {}
            path class="over" d=(cross) {}
        }
    }
}

/// The smallest value: a diamond of half width `r`.
pub fn lowest_mark(x: f64, y: f64, r: f64) -> Markup {
    let diamond = format!("M{} {}l{r} {r}l-{r} {r}l-{r} -{r}z", n(x), n(y - r));
    html! {
        g class="lowest" {
            title { "smallest error on the grid" }
            path class="under" d=(diamond) {}
            path class="over" d=(diamond) {}
        }
    }
}

/// How many distinct looks lines have before they repeat.
pub const SERIES: usize = 12;

/// Dashes of the line of a series.
pub fn dashes(series: usize) -> &'static str {
    const DASHES: [&str; SERIES] = [
        "none",
        "7 3",
        "2 2.5",
        "9 3 2 3",
        "none",
        "5 2",
        "2 4",
        "11 3 2 3 2 3",
        "none",
        "3.5 1.5",
        "8 2 1 2",
        "1.5 1.5",
    ];
    DASHES[series % SERIES]
}

/// The marker of a series.
pub fn marker(series: usize, x: f64, y: f64) -> Markup {
    let path = match series % SERIES {
        0 => "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
        1 => "M-3.5 -3.5h7v7h-7z",
        2 => "M0 -4.5L4.3 3.3H-4.3z",
        3 => "M0 -5L5 0L0 5L-5 0z",
        4 => "M-4 -4L4 4M-4 4L4 -4",
        5 => "M0 4.5L4.3 -3.3H-4.3z",
        6 => "M-4.5 0h9M0 -4.5v9",
        7 => "M-4.5 -4.5L4.5 -4.5L-4.5 4.5L4.5 4.5z",
        8 => "M-4.5 0L4.5 -4.5V4.5z",
        9 => "M4.5 0L-4.5 -4.5V4.5z",
        10 => "M0 -5L1.4 -1.6L5 -1.6L2.2 0.7L3.2 4.2L0 2.1L-3.2 4.2L-2.2 0.7L-5 -1.6L-1.4 -1.6z",
        _ => "M-4.5 0L-2.2 -4H2.2L4.5 0L2.2 4H-2.2z",
    };
    html! { path class={"mark s" (series % SERIES)} transform={"translate(" (n(x)) " " (n(y)) ")"} d=(path) {} }
}
