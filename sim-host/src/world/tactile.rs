//! The tactile pads: contact forces spread over cells, then read with the real hand's noise and steps.
//!
//! A contact presses the rubber over a few millimetres around it. Each cell gets the Gaussian's value at its centre,
//! scaled so that what the cells feel sums to the force; only a force into the pad's face counts.

use super::model::{Cell, Tactile};
use super::noise::Noise;
use rapier3d::prelude::Vector;
use tactus_common::limits::{PAD_CELLS, PAD_PERIOD_TICKS, PADS};
use tactus_common::reading::TactileImage;

/// Standard deviation of a contact's print in the rubber, metres. Assumed: half the pad's thickness plus a point's size.
pub const FOOTPRINT_M: f32 = 0.0025;
/// A contact this far from the nearest cell does not press the pad at all, metres.
const REACH_M: f32 = 4.0 * FOOTPRINT_M;

/// One contact on a link, in the link's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkForce {
    /// Point, metres.
    pub point_m: Vector,
    /// Normal force on the link, newtons (points into the link).
    pub force_n: Vector,
}

/// How the pads read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadParams {
    /// Standard deviation of a cell's noise, N/cm^2.
    pub noise_n_cm2: f32,
    /// Pressures below this read 0, N/cm^2.
    pub threshold_n_cm2: f32,
    /// Factor on every pressure.
    pub gain: f32,
    /// One count, N/cm^2.
    pub step_n_cm2: f32,
    /// Largest reading, N/cm^2.
    pub full_scale_n_cm2: f32,
}

/// The cells of all pads.
#[derive(Clone, Debug)]
pub struct Pads {
    cells: Vec<Vec<Cell>>,
}

impl Pads {
    /// The pads of a model.
    pub fn new(tactile: &Tactile) -> Self {
        Self { cells: (0..PADS).map(|pad| tactile.cells(pad)).collect() }
    }

    /// The cells of one pad, in its link's frame.
    pub fn cells(&self, pad: usize) -> &[Cell] {
        &self.cells[pad]
    }

    /// Adds one contact's pressure to `pressure_n_cm2`, cell by cell.
    pub fn press(&self, pad: usize, contact: &LinkForce, pressure_n_cm2: &mut [f32; PAD_CELLS]) {
        let cells = &self.cells[pad];
        let mut weights = [0.0_f32; PAD_CELLS];
        let (mut covered_m2, mut nearest_m) = (0.0_f32, f32::MAX);
        let mut into_pad_n = 0.0_f32;
        for (weight, cell) in weights.iter_mut().zip(cells) {
            let offset = contact.point_m - cell.centre_m;
            let distance_m = offset.length();
            *weight = libm::expf(-offset.length_squared() / (2.0 * FOOTPRINT_M * FOOTPRINT_M));
            covered_m2 += *weight * cell.area_m2;
            if distance_m < nearest_m {
                nearest_m = distance_m;
                into_pad_n = -contact.force_n.dot(cell.normal);
            }
        }
        if into_pad_n <= 0.0 || nearest_m > REACH_M {
            return;
        }
        // Beyond the pad's border part of the print is lost, but no more than half of it.
        let whole_m2 = core::f32::consts::TAU * FOOTPRINT_M * FOOTPRINT_M;
        let scale = into_pad_n / covered_m2.max(0.5 * whole_m2) * 1e-4;
        for (pressure, weight) in pressure_n_cm2.iter_mut().zip(weights) {
            *pressure += scale * weight;
        }
    }

    /// The pad whose turn it is at `tick`: one every third tick, each every [`PAD_PERIOD_TICKS`].
    pub fn due(tick: u32) -> Option<usize> {
        let stagger = PAD_PERIOD_TICKS / PADS as u32;
        let phase = tick % PAD_PERIOD_TICKS;
        phase.is_multiple_of(stagger).then_some((phase / stagger) as usize)
    }

    /// What the pad's electronics make of true pressures.
    pub fn read(
        pad: usize,
        stamp: u32,
        pressure_n_cm2: &[f32; PAD_CELLS],
        params: &PadParams,
        noise: &mut Noise,
    ) -> TactileImage {
        let mut image = TactileImage { pad: pad as u8, stamp, pressure_n_cm2: [0.0; PAD_CELLS] };
        for (out, pressure) in image.pressure_n_cm2.iter_mut().zip(pressure_n_cm2) {
            let felt = pressure * params.gain + noise.normal() * params.noise_n_cm2;
            if felt >= params.threshold_n_cm2 {
                let counts = libm::roundf(felt.min(params.full_scale_n_cm2) / params.step_n_cm2);
                *out = counts * params.step_n_cm2;
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::model::RobotModel;

    fn pads() -> Pads {
        Pads::new(&RobotModel::shipped().unwrap().extra.tactile)
    }

    fn total_n(pads: &Pads, pad: usize, pressure: &[f32; PAD_CELLS]) -> f32 {
        pads.cells[pad].iter().zip(pressure).map(|(c, p)| c.area_m2 * 1e4 * p).sum()
    }

    #[test]
    fn the_cells_under_a_contact_feel_its_whole_force() {
        let pads = pads();
        for (pad, at) in [(0, 7), (1, 13), (3, 8)] {
            let cell = pads.cells[pad][at];
            let mut p = [0.0; PAD_CELLS];
            pads.press(pad, &LinkForce { point_m: cell.centre_m, force_n: cell.normal * -2.0 }, &mut p);
            let total = total_n(&pads, pad, &p);
            assert!((total - 2.0).abs() < 0.2, "pad {pad}: {total} N");
            let strongest = (0..PAD_CELLS).max_by(|a, b| p[*a].total_cmp(&p[*b])).unwrap();
            assert_eq!(strongest, at, "the pressed cell feels it most");
        }
    }

    #[test]
    fn a_force_on_the_back_or_far_away_is_not_felt() {
        let pads = pads();
        let cell = pads.cells[0][7];
        let mut p = [0.0; PAD_CELLS];
        pads.press(0, &LinkForce { point_m: cell.centre_m, force_n: cell.normal * 2.0 }, &mut p);
        pads.press(0, &LinkForce { point_m: Vector::new(0.0, 0.0095, 0.0), force_n: cell.normal * -2.0 }, &mut p);
        assert_eq!(p, [0.0; PAD_CELLS]);
    }

    #[test]
    fn every_pad_is_scanned_once_a_period_and_one_at_a_time() {
        let mut seen = [0; PADS];
        for tick in 0..PAD_PERIOD_TICKS {
            if let Some(pad) = Pads::due(tick) {
                seen[pad] += 1;
            }
        }
        assert_eq!(seen, [1; PADS]);
    }

    #[test]
    fn readings_are_whole_counts_within_range() {
        let params = PadParams {
            noise_n_cm2: 0.01,
            threshold_n_cm2: 0.05,
            gain: 1.0,
            step_n_cm2: 1.0 / 256.0,
            full_scale_n_cm2: 15.996_094,
        };
        let mut p = [0.0; PAD_CELLS];
        p[3] = 40.0;
        p[4] = 1.234;
        p[5] = 0.01;
        let image = Pads::read(0, 9, &p, &params, &mut Noise::new(1));
        assert_eq!(image.pressure_n_cm2[3], 15.996_094);
        assert_eq!(image.pressure_n_cm2[5], 0.0);
        for v in image.pressure_n_cm2 {
            assert_eq!(v * 256.0, libm::roundf(v * 256.0));
        }
    }
}
