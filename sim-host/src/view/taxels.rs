//! Where the cells of a pad are drawn: on the hand, and in the picture of the pad.
//!
//! A recording says where cells are, which way they face and how large they are, row by row; here rows and sides are found
//! again: cells of one row are nearer to each other than to the next row's first.

use super::payload::Taxel;
use crate::recording::sample::Pad;
use nalgebra::Vector3;

/// Share of the distance between cells of a row that a cell fills.
const FILL: f32 = 0.9;
/// Cells follow one another in a row while they are at most this much farther apart than the nearest two.
const SAME_ROW: f32 = 1.5;

/// The cells of a pad.
pub fn taxels(pad: &Pad) -> Vec<Taxel> {
    let centres: Vec<Vector3<f32>> = pad.centre_m.iter().map(|c| Vector3::from(*c)).collect();
    let steps: Vec<Vector3<f32>> = centres.windows(2).map(|two| two[1] - two[0]).collect();
    let pitch_m = steps.iter().map(Vector3::norm).fold(f32::INFINITY, f32::min);
    let rows = rows(&steps, SAME_ROW * pitch_m, centres.len());
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
    let mut taxels = Vec::new();
    for (row, cells) in rows.iter().enumerate() {
        for (column, cell) in cells.iter().copied().enumerate() {
            let across = match cells[..] {
                [first, .., last] => (centres[last] - centres[first]).normalize(),
                _ => Vector3::z(),
            };
            let normal = pad.normal.get(cell).copied().map_or_else(Vector3::z, Vector3::from);
            let width_m = FILL * pitch_m;
            let length_m = pad.area_m2.get(cell).copied().unwrap_or(0.0) / width_m;
            taxels.push(Taxel {
                centre_m: centres[cell].into(),
                normal: normal.into(),
                along: across.into(),
                size_m: [width_m, length_m],
                place: [column as f32 + (widest - cells.len()) as f32 / 2.0, row as f32],
            });
        }
    }
    taxels
}

/// Numbers of the cells of each row.
fn rows(steps: &[Vector3<f32>], longest_m: f32, count: usize) -> Vec<Vec<usize>> {
    let mut rows: Vec<Vec<usize>> = Vec::new();
    for cell in 0..count {
        let goes_on = cell > 0 && steps[cell - 1].norm() <= longest_m;
        match rows.last_mut() {
            Some(row) if goes_on => row.push(cell),
            _ => rows.push(vec![cell]),
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::model::RobotModel;

    fn shipped(pad: usize) -> Vec<Taxel> {
        taxels(&Pad::new(pad, "link", &RobotModel::shipped().unwrap().extra.tactile.cells(pad)))
    }

    #[test]
    fn a_fingertip_has_eight_rows_of_three_cells_of_its_true_size() {
        let taxels = shipped(0);
        let places: Vec<[f32; 2]> = taxels.iter().map(|t| t.place).collect();
        assert_eq!(places[..4], [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]]);
        assert_eq!(places[23], [2.0, 7.0]);
        // Barrett's cells: 4.7 mm wide, 5.5 mm long.
        assert!((taxels[0].size_m[0] - 4.7e-3).abs() < 5e-5 && (taxels[0].size_m[1] - 5.5e-3).abs() < 5e-5);
    }

    #[test]
    fn the_palm_has_rows_of_five_and_seven_cells() {
        let places: Vec<[f32; 2]> = shipped(3).iter().map(|t| t.place).collect();
        assert_eq!([places[0], places[4], places[5], places[11]], [[1.0, 0.0], [5.0, 0.0], [0.0, 1.0], [6.0, 1.0]]);
        assert_eq!(places[23], [5.0, 3.0]);
    }
}
