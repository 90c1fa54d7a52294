//! From the ends of the searches to a belief.

use super::Update;
use crate::belief::{Belief, MODES_MAX, Mode};
use crate::error::Evaluation;
use crate::error::geometric::Residuals;
use crate::optimise::Found;
use crate::sort::insertion_sort;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};
use tactus_common::pose::PlanarPose;

/// Ends closer than this are one.
const SAME_POSITION_M: f32 = 1.5e-3;
const SAME_YAW_RAD: f32 = 0.015;
/// Error above the least, in chi-squared units, up to which an end is a mode: 99.7 % for three components.
const MODE_MARGIN: f32 = 14.0;
/// Least standard deviations that are ever claimed: errors of the model that all contacts share (size of the box,
/// kinematics of the hand) do not average out.
const FLOOR_POSITION_M: f32 = 0.3e-3;
const FLOOR_YAW_RAD: f32 = 2e-3;
/// Standard deviations of a belief by a published error, which has none of its own: the thesis finds the object to about
/// 10 mm, two of these, and stops there; the yaw is what 5 mm are at the box's ends.
const PUBLISHED_POSITION_M: f32 = 5e-3;
const PUBLISHED_YAW_RAD: f32 = 0.05;

impl Update {
    /// The belief from the polished ends.
    pub(super) fn gather(&mut self, best: &Found, residuals: Residuals) {
        let mut modes: Vec<Mode, MODES_MAX> = Vec::new();
        for end in &self.polished {
            if end.evaluation.error <= best.evaluation.error + MODE_MARGIN {
                let mode = Mode {
                    pose: self.beside(&best.pose, end.pose),
                    covariance: self.covariance(&end.evaluation),
                    weight: 0.0,
                    error: end.evaluation.error,
                };
                let _ = modes.push(mode);
            }
        }
        self.stats.modes = modes.len() as u8;
        self.stats.error = best.evaluation.error;
        if let Some(belief) = Belief::from_modes(modes, residuals) {
            self.belief = belief;
        }
    }

    /// The pose with the yaw, of those that look alike, that is the nearest to the best one's: a mean is to mean something.
    fn beside(&self, best: &PlanarPose, pose: PlanarPose) -> PlanarPose {
        let symmetry_rad = self.prior.shape.yaw_symmetry_rad();
        if libm::fabsf(pose.phi_rad - best.phi_rad) <= 0.5 * symmetry_rad {
            return pose;
        }
        PlanarPose { phi_rad: best.phi_rad + pose.turn_from_rad(best, symmetry_rad), ..pose }
    }

    /// Inverse of the evidence's information plus the prior's, over the components that are not known exactly, plus
    /// the floor.
    fn covariance(&self, evaluation: &Evaluation) -> Matrix3<f32> {
        let mut information = evaluation.slope.map_or_else(Matrix3::zeros, |s| s.information);
        let prior = self.prior.information();
        for axis in 0..3 {
            match prior[axis] {
                Some(known) => information[(axis, axis)] += known,
                None => {
                    for other in 0..3 {
                        information[(axis, other)] = 0.0;
                        information[(other, axis)] = 0.0;
                    }
                    information[(axis, axis)] = 1.0;
                }
            }
        }
        let mut covariance = match information.cholesky() {
            Some(root) => root.inverse(),
            None => Matrix3::from_diagonal(&nalgebra::Vector3::from(prior.map(|p| p.map_or(0.0, |i| 1.0 / i)))),
        };
        let floors = [FLOOR_POSITION_M, FLOOR_POSITION_M, FLOOR_YAW_RAD];
        for axis in 0..3 {
            covariance[(axis, axis)] =
                if prior[axis].is_some() { covariance[(axis, axis)] + floors[axis] * floors[axis] } else { 0.0 };
        }
        covariance
    }

    /// The belief that a published error leads to: the pose found, as wide as stated above.
    pub(super) fn gather_published(&mut self, found: &Found) {
        let stated = [PUBLISHED_POSITION_M, PUBLISHED_POSITION_M, PUBLISHED_YAW_RAD];
        let known = self.prior.information();
        let variance =
            Vector3::from_fn(|axis, _| if known[axis].is_some() { stated[axis] * stated[axis] } else { 0.0 });
        let covariance = Matrix3::from_diagonal(&variance);
        let error = found.evaluation.error;
        let mut modes: Vec<Mode, MODES_MAX> = Vec::new();
        let _ = modes.push(Mode { pose: found.pose, covariance, weight: 1.0, error });
        (self.stats.modes, self.stats.error) = (1, error);
        if let Some(belief) = Belief::from_modes(modes, Residuals::default()) {
            self.belief = belief;
        }
    }
}

/// Puts ends in order of error.
pub(super) fn sort_by_error<const N: usize>(ends: &mut Vec<Found, N>) {
    insertion_sort(ends, |a, b| a.evaluation.error.total_cmp(&b.evaluation.error));
}

/// Removes from a list in order of error every end that is next to a better one, for an object of this symmetry.
pub(super) fn merge<const N: usize>(ends: &mut Vec<Found, N>, symmetry_rad: f32) {
    let mut kept = 0;
    for at in 0..ends.len() {
        let Some(end) = ends.get(at).copied() else { break };
        let is_known = ends.iter().take(kept).any(|better| is_same(&better.pose, &end.pose, symmetry_rad));
        if end.evaluation.is_finite() && !is_known {
            if let Some(slot) = ends.get_mut(kept) {
                *slot = end;
            }
            kept += 1;
        }
    }
    ends.truncate(kept);
}

pub(super) fn is_same(a: &PlanarPose, b: &PlanarPose, symmetry_rad: f32) -> bool {
    libm::fabsf(a.x_m - b.x_m) < SAME_POSITION_M
        && libm::fabsf(a.y_m - b.y_m) < SAME_POSITION_M
        && libm::fabsf(a.turn_from_rad(b, symmetry_rad)) < SAME_YAW_RAD
}
