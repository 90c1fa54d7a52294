//! A map of cells over x and y, with the truth marked.

use super::colour::Scale;
use super::input::Truth;
use super::raster::Raster;
use super::svg::{self, Frame, n};
use maud::{Markup, html};

/// How a cell is filled.
pub enum Fill {
    /// A colour.
    Colour(String),
    /// A class of the style sheet.
    Class(&'static str),
    /// One of the hatches.
    Hatch(usize),
}

/// One cell: column, row, fill, and what is told about it.
pub struct Cell {
    /// Column of the raster.
    pub ix: usize,
    /// Row of the raster.
    pub iy: usize,
    /// How it looks.
    pub fill: Fill,
    /// What is shown when it is pointed at.
    pub tip: String,
}

/// A drawing of cells.
pub struct HeatMap<'a> {
    /// The grid.
    pub raster: &'a Raster,
    /// The cells.
    pub cells: Vec<Cell>,
    /// The true pose.
    pub truth: Option<Truth>,
    /// The cells with the smallest value.
    pub lowest: Vec<(usize, usize)>,
    /// Bar of the colours, and its name.
    pub bar: Option<(&'a Scale, &'static str)>,
    /// What stands above it.
    pub heading: String,
    /// What it shows, for those who cannot see it.
    pub label: String,
    /// Width of the plotted area, pixels, at most.
    pub width: f64,
}

const LEFT: f64 = 58.0;
const BOTTOM: f64 = 40.0;
const TOP: f64 = 26.0;
/// Grids of more cells than this are drawn without tips: they would be most of the page.
const TIPS: usize = 4000;

impl HeatMap<'_> {
    /// Width and height of the plotted area: whole pixels a cell, so that there are no seams. Both axes have the same
    /// scale unless the grid is very long or very flat.
    fn size(&self) -> (f64, f64) {
        let Raster { x, y, .. } = self.raster;
        let (columns, rows) = (x.cells(), y.cells());
        let wide = if columns * 2.0 > self.width { self.width / columns } else { (self.width / columns).floor() };
        let (least, most) = ((self.width * 0.12 / rows).ceil(), (self.width / rows).floor().max(1.0));
        let high = if rows * 2.0 > self.width {
            self.width / rows
        } else {
            (wide * y.step / x.step).round().min(most).max(least)
        };
        (wide * columns, high * rows)
    }

    /// The SVG.
    pub fn draw(&self) -> Markup {
        let Raster { x, y, .. } = self.raster;
        let (width, height) = self.size();
        let (x_range, y_range) = ([x.low(), x.high()], [y.low(), y.high()]);
        let frame = Frame { left: LEFT, top: TOP, width, height, x: x_range, y: y_range };
        let total = frame.right() + if self.bar.is_some() { 80.0 } else { 12.0 };
        let (count_x, count_y) = ((width / 55.0).max(3.0) as usize, (height / 24.0).clamp(3.0, 9.0) as usize);
        let y_ticks = match y.values[..] {
            [only] => vec![(only, super::number::sig(only, 3))],
            _ => frame.y_ticks(count_y),
        };
        html! {
            svg class="plot" role="img" aria-label=(self.label) viewBox={"0 0 " (n(total)) " " (n(frame.bottom() + BOTTOM))} width=(n(total)) {
                text class="heading" x=(n(frame.left)) y=(n(frame.top - 9.0)) { (self.heading) }
                rect class="missing" x=(n(frame.left)) y=(n(frame.top)) width=(n(frame.width)) height=(n(frame.height)) {}
                g class="cells" { @for cell in &self.cells { (self.cell(&frame, cell)) } }
                (frame.axes(&frame.x_ticks(count_x), &y_ticks, ["x (m)", "y (m)"], false))
                @for (ix, iy) in &self.lowest {
                    (svg::lowest_mark(frame.px(x.values[*ix]), frame.py(y.values[*iy]), if self.lowest.len() > 1 { 3.0 } else { 6.0 }))
                }
                @if let Some(t) = self.truth.filter(|t| inside(x_range, t.x) && inside(y_range, t.y)) {
                    (svg::truth_mark(frame.px(t.x), frame.py(t.y)))
                }
                @if let Some((scale, name)) = &self.bar {
                    (svg::colour_bar(scale, frame.right() + 14.0, frame.top, frame.height, name))
                }
            }
        }
    }

    fn cell(&self, frame: &Frame, cell: &Cell) -> Markup {
        let Raster { x, y, .. } = self.raster;
        let left = frame.px(x.values[cell.ix] - x.step / 2.0);
        let top = frame.py(y.values[cell.iy] + y.step / 2.0);
        let width = x.step / (frame.x[1] - frame.x[0]) * frame.width;
        let height = y.step / (frame.y[1] - frame.y[0]) * frame.height;
        // Colours overlap a little: a scaled drawing shows no seams either.
        let more = if matches!(cell.fill, Fill::Class(_)) { 0.0 } else { 0.6 };
        let (width, height) = ((width + more).min(frame.right() - left), (height + more).min(frame.bottom() - top));
        let (class, fill) = match &cell.fill {
            Fill::Colour(colour) => (None, Some(colour.clone())),
            Fill::Class(class) => (Some(*class), None),
            Fill::Hatch(i) => (None, Some(svg::hatch(*i))),
        };
        html! {
            rect class=[class] fill=[fill] x=(n(left)) y=(n(top)) width=(n(width)) height=(n(height)) {
                @if self.cells.len() <= TIPS { title { (cell.tip) } }
            }
        }
    }
}

fn inside([low, high]: [f64; 2], v: f64) -> bool {
    (low..=high).contains(&v)
}
