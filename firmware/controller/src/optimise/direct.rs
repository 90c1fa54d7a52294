//! DIRECT: the box is divided into ever smaller boxes, the promising ones first; no random numbers, no slopes.
//!
//! Jones, Perttunen & Stuckman (1993), "Lipschitzian optimization without the Lipschitz constant", sections 3-5: boxes
//! are evaluated at their middles; those on the lower right hull of error over size are divided in three along their
//! longest sides, for some Lipschitz constant they may hold the minimum. Of equal boxes one is divided at a time
//! (Gablonsky & Kelley 2001). Chosen over a coarse-to-fine refinement of a particle cloud (Scaling Series) since it asks
//! nothing about the error's scale (contact counts, angles, chi-squared), walks over plateaus by itself, and visits every
//! part of the region sooner or later.
//!
//! Memory: [`CELLS_MAX`] boxes. When they are used up, the box with the largest error makes room, which gives up the
//! promise to visit every part. An error that is no number counts as the largest that was seen.

use super::StopReason;
use super::search::{Next, Point, Sample, Search, Setup, Strategy};
use heapless::Vec;

/// Boxes kept. 20 bytes each.
pub const CELLS_MAX: usize = 320;
/// A side is divided at most this often: 3^-10 of it is a fifth of the default tolerance.
const LEVEL_MAX: u8 = 10;
/// Sizes of boxes: the sum of the levels of three sides.
const SIZES: usize = 3 * LEVEL_MAX as usize + 1;
/// A box must promise to better the best error by this part of it (Jones: 1e-4).
const PROMISE: f32 = 1e-4;

/// A box: its middle, the error there, and how often each side was divided.
#[derive(Clone, Copy, Debug)]
struct Cell {
    middle: [f32; 3],
    error: f32,
    levels: [u8; 3],
}

/// A box being divided.
#[derive(Clone, Copy, Debug, Default)]
struct Division {
    cell: u16,
    /// The longest sides.
    axes: [u8; 3],
    count: u8,
    /// Errors at the points below and above the middle, per side.
    errors: [[f32; 2]; 3],
    /// The point being evaluated.
    next: u8,
}

/// The strategy. About 6.5 KiB.
#[derive(Clone, Debug)]
pub struct Dividing {
    free: usize,
    level_max: u8,
    cells: Vec<Cell, CELLS_MAX>,
    /// Boxes still to be divided in this round.
    chosen: Vec<u16, SIZES>,
    division: Division,
    least: f32,
    largest: f32,
    has_begun: bool,
}

impl Strategy for Dividing {
    fn new(setup: &Setup) -> Self {
        let mut level_max = 1;
        let mut half_side = 1.0 / 3.0;
        while half_side > setup.options.step_min && level_max < LEVEL_MAX {
            half_side /= 3.0;
            level_max += 1;
        }
        Self {
            free: setup.free,
            level_max,
            cells: Vec::new(),
            chosen: Vec::new(),
            division: Division::default(),
            least: f32::INFINITY,
            largest: 0.0,
            has_begun: false,
        }
    }

    fn next(&mut self, sample: &Sample) -> Next {
        if sample.error.is_finite() {
            self.least = self.least.min(sample.error);
            self.largest = self.largest.max(sample.error);
        }
        if !self.has_begun {
            // The start is told for the accounts; the division begins with the whole box.
            self.has_begun = true;
            return Next::Try(Point::zeros());
        }
        if self.cells.is_empty() {
            let _ = self.cells.push(Cell { middle: [0.0; 3], error: sample.error, levels: [0; 3] });
        } else {
            let Division { next, count, .. } = self.division;
            if let Some(pair) = self.division.errors.get_mut(usize::from(next / 2)) {
                pair[usize::from(next % 2)] = sample.error;
            }
            self.division.next += 1;
            if self.division.next < 2 * count {
                return Next::Try(self.probe());
            }
            self.divide();
        }
        self.begin_division()
    }
}

impl Dividing {
    /// Takes the next box that was chosen, choosing anew when there is none.
    fn begin_division(&mut self) -> Next {
        if self.chosen.is_empty() {
            self.choose();
        }
        // The largest were pushed first and come last: the smallest promise most.
        let Some(index) = self.chosen.pop() else { return Next::Stop(StopReason::Converged) };
        let Some(cell) = self.cells.get(usize::from(index)) else { return Next::Stop(StopReason::Converged) };
        let least = cell.levels.iter().take(self.free).fold(u8::MAX, |least, level| least.min(*level));
        let mut division = Division { cell: index, ..Division::default() };
        for axis in 0..self.free {
            if cell.levels[axis] == least {
                division.axes[usize::from(division.count)] = axis as u8;
                division.count += 1;
            }
        }
        self.division = division;
        Next::Try(self.probe())
    }

    /// The point to be evaluated next: a third of a side below or above the middle.
    fn probe(&self) -> Point {
        let Division { cell, axes, next, .. } = self.division;
        let Some(cell) = self.cells.get(usize::from(cell)) else { return Point::zeros() };
        let axis = usize::from(axes[usize::from(next / 2)]);
        let mut point = Point::from(cell.middle);
        point[axis] += if next % 2 == 0 { -third(cell.levels[axis]) } else { third(cell.levels[axis]) };
        point
    }

    /// Divides the box: the side with the best point first, so that this point gets the largest box.
    fn divide(&mut self) {
        let Division { cell, mut axes, count, mut errors, .. } = self.division;
        let Some(mut parent) = self.cells.get(usize::from(cell)).copied() else { return };
        let count = usize::from(count);
        let least = |pair: &[f32; 2]| pair[0].min(pair[1]);
        for end in 1..count {
            for at in (1..=end).rev() {
                if least(&errors[at]) < least(&errors[at - 1]) {
                    errors.swap(at, at - 1);
                    axes.swap(at, at - 1);
                }
            }
        }
        for (axis, pair) in axes.iter().map(|axis| usize::from(*axis)).zip(errors).take(count) {
            let offset = third(parent.levels[axis]);
            parent.levels[axis] += 1;
            for (error, offset) in pair.into_iter().zip([-offset, offset]) {
                let mut child = Cell { error, ..parent };
                child.middle[axis] += offset;
                self.keep(child, cell);
            }
        }
        if let Some(slot) = self.cells.get_mut(usize::from(cell)) {
            *slot = parent;
        }
    }

    /// Adds a box; if there is no room, in place of the one with the largest error, unless it is that one itself.
    fn keep(&mut self, cell: Cell, parent: u16) {
        let Err(cell) = self.cells.push(cell) else { return };
        let worst = (0..CELLS_MAX as u16).filter(|index| *index != parent && !self.chosen.contains(index)).fold(
            None,
            |worst: Option<(u16, f32)>, index| {
                let error = self.cells.get(usize::from(index)).map_or(f32::NEG_INFINITY, |cell| cell.error);
                if worst.is_none_or(|(_, largest)| error > largest) { Some((index, error)) } else { worst }
            },
        );
        if let Some((index, largest)) = worst
            && largest > cell.error
            && let Some(slot) = self.cells.get_mut(usize::from(index))
        {
            *slot = cell;
        }
    }

    /// The boxes that may hold the minimum: for each size the best one, if it is on the lower right hull.
    fn choose(&mut self) {
        let mut best: [Option<(u16, f32)>; SIZES] = [None; SIZES];
        for (index, cell) in self.cells.iter().enumerate() {
            let is_finest = cell.levels.iter().take(self.free).all(|level| *level >= self.level_max);
            let size = cell.levels.iter().map(|level| usize::from(*level)).sum::<usize>();
            let error = if cell.error.is_finite() { cell.error } else { self.largest };
            if let Some(slot) = best.get_mut(size)
                && !is_finest
                && slot.is_none_or(|(_, least)| error < least)
            {
                *slot = Some((index as u16, error));
            }
        }
        let least = if self.least.is_finite() { self.least } else { 0.0 };
        for (size, slot) in best.iter().enumerate() {
            let Some((index, error)) = *slot else { continue };
            let mine = self.radius(size);
            let (mut slope_min, mut slope_max) = (0.0_f32, f32::INFINITY);
            for (other_size, other) in best.iter().enumerate() {
                let Some((_, other_error)) = *other else { continue };
                let other = self.radius(other_size);
                if other_size > size {
                    slope_min = slope_min.max((error - other_error) / (mine - other));
                } else if other_size < size {
                    slope_max = slope_max.min((other_error - error) / (other - mine));
                }
            }
            let promises = error - slope_max * mine <= least - PROMISE * libm::fabsf(least);
            if slope_min <= slope_max && slope_max > 0.0 && promises {
                let _ = self.chosen.push(index);
            }
        }
    }

    /// From the middle to a corner of a box of this size (the sum of its levels; sides differ by one level at most).
    fn radius(&self, size: usize) -> f32 {
        let free = self.free.max(1);
        let (level, finer) = (size / free, size % free);
        let coarse = libm::powf(9.0, -(level as f32));
        libm::sqrtf(coarse * ((free - finer) as f32 + finer as f32 / 9.0))
    }
}

/// A third of a side that was divided `level` times.
fn third(level: u8) -> f32 {
    2.0 * libm::powf(3.0, -f32::from(level) - 1.0)
}

/// DIRECT.
pub type Direct = Search<Dividing>;

#[cfg(test)]
mod tests {
    use super::super::SearchOptions;
    use super::*;

    fn divided(free: usize, evaluations: usize, error: impl Fn(&Point) -> f32) -> Dividing {
        let options = SearchOptions::default();
        let setup = Setup { start: Point::zeros(), free, steps: Point::repeat(0.01), options };
        let mut direct = Dividing::new(&setup);
        let mut point = setup.start;
        for _ in 0..evaluations {
            match direct.next(&Sample { point, error: error(&point), model: None }) {
                Next::Try(next) => point = next,
                Next::Stop(_) => break,
            }
        }
        direct
    }

    fn bowl(p: &Point) -> f32 {
        (p - Point::new(0.3, -0.2, 0.0)).norm_squared()
    }

    #[test]
    fn boxes_fill_the_region_without_gaps_while_there_is_room() {
        for free in 1..=3 {
            for evaluations in [2, 9, 30, 150] {
                let direct = divided(free, evaluations, bowl);
                let volume =
                    |cell: &Cell| cell.levels.iter().map(|level| 3_f32.powi(-i32::from(*level))).product::<f32>();
                let filled: f32 = direct.cells.iter().map(volume).sum();
                assert!((filled - 1.0).abs() < 1e-4, "{free} {evaluations}: {filled}");
                for (index, cell) in direct.cells.iter().enumerate() {
                    let apart = |other: &Cell| {
                        (0..free).any(|axis| {
                            let reach = 1.5 * (third(cell.levels[axis]) + third(other.levels[axis]));
                            (cell.middle[axis] - other.middle[axis]).abs() > 0.99 * reach
                        })
                    };
                    assert!(direct.cells.iter().skip(index + 1).all(apart), "{cell:?}");
                }
            }
        }
    }

    #[test]
    fn large_boxes_are_visited_even_where_small_ones_are_better() {
        let direct = divided(2, 150, bowl);
        let coarsest = direct.cells.iter().map(|cell| cell.levels[0] + cell.levels[1]).min();
        let finest = direct.cells.iter().map(|cell| cell.levels[0] + cell.levels[1]).max();
        assert!(coarsest >= Some(3) && finest >= Some(9), "{coarsest:?} {finest:?}");
    }

    #[test]
    fn a_full_store_goes_on_with_the_better_boxes() {
        let direct = divided(3, 2000, |p| (p - Point::new(0.3, -0.2, 0.5)).norm_squared());
        assert_eq!(direct.cells.len(), CELLS_MAX);
        assert!(direct.least < 1e-6, "{}", direct.least);
    }
}
