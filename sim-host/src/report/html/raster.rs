//! The grid behind a list of poses.

use super::input::Grid;
use super::row::At;

/// Two values closer than this are the same grid line, metres or radians: files hold single precision.
const SAME: f64 = 1e-6;

/// The values of one component, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Grid lines.
    pub values: Vec<f64>,
    /// Distance of neighbours (the median).
    pub step: f64,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>, declared: Option<[f64; 3]>) -> Self {
        let mut all: Vec<f64> = values.collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| (*a - *b).abs() < SAME);
        let declared = declared.map(|[_, _, step]| step).filter(|s| s.is_finite() && *s > SAME);
        let usual = super::number::quantile(all.windows(2).map(|w| Some(w[1] - w[0])), 0.5);
        Self { step: usual.or(declared).unwrap_or(0.01), values: all }
    }

    /// Which grid line this is.
    pub fn index(&self, value: f64) -> Option<usize> {
        let i = self.values.partition_point(|v| *v < value - SAME);
        self.values.get(i).filter(|v| (**v - value).abs() < 2.0 * SAME).map(|_| i)
    }

    /// Cells from end to end.
    pub fn cells(&self) -> f64 {
        ((self.high() - self.low()) / self.step).round()
    }

    /// Where the first cell begins.
    pub fn low(&self) -> f64 {
        self.values.first().copied().unwrap_or(0.0) - self.step / 2.0
    }

    /// Where the last cell ends.
    pub fn high(&self) -> f64 {
        self.values.last().copied().unwrap_or(0.0) + self.step / 2.0
    }
}

/// The grid of a surface or a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Metres.
    pub x: Axis,
    /// Metres.
    pub y: Axis,
    /// Radians.
    pub phi: Axis,
}

impl Raster {
    /// The grid of these poses; `declared` helps where a component has one value only.
    pub fn of(poses: impl Iterator<Item = At> + Clone, declared: Option<&Grid>) -> Self {
        let mut x = Axis::of(poses.clone().map(|p| p.x), declared.and_then(|g| g.x));
        let mut y = Axis::of(poses.clone().map(|p| p.y), declared.and_then(|g| g.y));
        // A component with one value has no step of its own, whatever the file says.
        match (x.values.len(), y.values.len()) {
            (1, 2..) => x.step = y.step,
            (2.., 1) => y.step = x.step,
            _ => {}
        }
        Self { x, y, phi: Axis::of(poses.map(|p| p.phi), None) }
    }

    /// Items by cell of the slice `phi`: `[iy * width + ix]`.
    pub fn slice<'a, T>(&self, phi: usize, items: &'a [T], at: impl Fn(&T) -> At) -> Vec<Option<&'a T>> {
        let mut cells = vec![None; self.x.values.len() * self.y.values.len()];
        for item in items {
            let at = at(item);
            if self.phi.index(at.phi) != Some(phi) {
                continue;
            }
            if let (Some(ix), Some(iy)) = (self.x.index(at.x), self.y.index(at.y)) {
                cells[iy * self.x.values.len() + ix] = Some(item);
            }
        }
        cells
    }
}

/// What the shape of a surface means for a search on its grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terrain {
    /// Places (one cell, or a plain of equal ones) from which every step leads up.
    pub minima: usize,
    /// Shares of cells whose neighbours along x, and along y, have the same error: no slope there.
    pub flat: [f64; 2],
}

/// Studies a slice: `values[iy * width + ix]`, four neighbours a cell. Equal means within a millionth of the range.
pub fn terrain(values: &[Option<f64>], width: usize) -> Terrain {
    let known = || values.iter().flatten().copied();
    let range = known().fold(f64::NEG_INFINITY, f64::max) - known().fold(f64::INFINITY, f64::min);
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * range;
    let neighbours = |i: usize| {
        let column = i % width.max(1);
        [
            (column > 0).then(|| i - 1),
            (column + 1 < width).then_some(i + 1),
            i.checked_sub(width),
            (i + width < values.len()).then_some(i + width),
        ]
        .into_iter()
        .flatten()
        .filter_map(|n| values[n].map(|v| (n, v)))
    };
    let mut seen = vec![false; values.len()];
    let mut minima = 0;
    let mut flat = [0; 2];
    for start in 0..values.len() {
        let Some(level) = values[start] else { continue };
        for (along_y, count) in flat.iter_mut().enumerate() {
            let along = |n: usize| usize::from(n.abs_diff(start) != 1 || width == 1) == along_y;
            *count += usize::from(neighbours(start).filter(|(n, _)| along(*n)).all(|(_, v)| same(v, level)));
        }
        if seen[start] {
            continue;
        }
        // The plain around `start`: every cell enters the list once.
        let mut plain = vec![start];
        seen[start] = true;
        let mut lowest = true;
        let mut next = 0;
        while let Some(&cell) = plain.get(next) {
            next += 1;
            for (n, v) in neighbours(cell) {
                if same(v, level) {
                    if !seen[n] {
                        seen[n] = true;
                        plain.push(n);
                    }
                } else if v < level {
                    lowest = false;
                }
            }
        }
        minima += usize::from(lowest);
    }
    Terrain { minima, flat: flat.map(|count| super::number::share(count, known().count())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_lines_are_found_in_single_precision() {
        let poses = [0.1f32, 0.11, 0.12].map(|x| At { x: f64::from(x), y: -0.1, phi: 0.0 });
        let raster = Raster::of(poses.into_iter(), None);
        assert_eq!(raster.x.values.len(), 3);
        assert_eq!(raster.x.index(0.11), Some(1));
        assert_eq!(raster.x.index(0.115), None);
        assert!((raster.x.step - 0.01).abs() < 1e-6);
    }

    #[test]
    fn a_plain_is_one_minimum_and_a_slope_is_none() {
        let slope: Vec<_> = [1.0, 2.0, 3.0, 4.0].map(Some).to_vec();
        assert_eq!(terrain(&slope, 4), Terrain { minima: 1, flat: [0.0, 1.0] });
        let plains: Vec<_> = [0.0, 0.0, 0.0, 5.0, 1.0, 1.0].map(Some).to_vec();
        assert_eq!(terrain(&plains, 6), Terrain { minima: 2, flat: [0.5, 1.0] });
        assert_eq!(terrain(&[Some(1.0), None, Some(1.0)], 3).minima, 2);
        // Two by two, rows 1 1 and 2 2: flat along x only.
        assert_eq!(terrain(&[1.0, 1.0, 2.0, 2.0].map(Some), 2), Terrain { minima: 1, flat: [1.0, 0.0] });
    }
}
