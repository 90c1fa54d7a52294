//! Are the modes as narrow as their covariances say?
//!
//! The information at an end of a search is that of its tangents. Where a contact only just touches, beside an edge, it
//! holds on one side alone: on the other the error may stay flat for centimetres. So from the best ends steps are taken
//! along each component, as the covariance couples it with the others. At three standard deviations the error should
//! rise by 9; where it hardly rises, the pose there is a mode as well, and the step is doubled. The modes of a valley
//! then spread as it does.

use super::gather::{MODE_MARGIN, SAME_POSITION_M, SAME_YAW_RAD};
use super::{Phase, Update};
use crate::error::{Geometric, GeometricConfig};
use crate::evidence::EvidenceStore;
use crate::optimise::Found;
use crate::work::{MATRICES, Work};
use tactus_common::pose::PlanarPose;

/// Ends from which steps are taken, the best ones.
const PROBED_MAX: usize = 3;
/// Length of the first step, in standard deviations.
const FIRST_STEP_SIGMAS: f32 = 3.0;
/// A rise of the error below this is none, in chi-squared units: a quarter of what the first step should cost.
const FLAT_RISE: f32 = 2.25;
/// Steps in one direction, each twice as long as the one before: from 1.5 mm to 48 mm.
const STEPS_MAX: u8 = 6;
/// Directions: forth and back along each component.
const SIDES: u8 = 6;

/// The step to take next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Probe {
    /// Index of the end that it starts from.
    end: usize,
    /// Direction: component, and forth or back.
    side: u8,
    /// Steps taken in this direction.
    step: u8,
}

impl Probe {
    fn next_side(self) -> Self {
        let side = self.side + 1;
        if side < SIDES { Self { side, step: 0, ..self } } else { Self { end: self.end + 1, side: 0, step: 0 } }
    }

    fn next_step(self) -> Self {
        if self.step + 1 < STEPS_MAX { Self { step: self.step + 1, ..self } } else { self.next_side() }
    }
}

impl Update {
    /// Begins with the ends in order of error; those that are no modes go.
    pub(super) fn start_probing(&mut self) {
        let most = self.polished.first().map_or(0.0, |best| best.evaluation.error + MODE_MARGIN);
        self.polished.retain(|end| end.evaluation.error <= most);
        self.probed = self.polished.len().min(PROBED_MAX);
        self.phase = Phase::Probe(Probe::default());
    }

    /// One step, or what the work allows of it.
    pub(super) fn probe(&mut self, probe: Probe, narrow: &GeometricConfig, store: &EvidenceStore, work: &mut Work) {
        let from = self.polished.get(probe.end).copied().filter(|_| probe.end < self.probed);
        let Some(from) = from.filter(|_| self.may_evaluate() && !self.polished.is_full()) else {
            self.finish_probing();
            return;
        };
        let narrow = Geometric::new(store, &self.prior.shape, narrow);
        let under_way = match &mut self.evaluation {
            Some(under_way) => under_way,
            None => {
                work.spend(MATRICES);
                let Some(pose) = self.probe_pose(probe, &from) else {
                    self.phase = Phase::Probe(probe.next_side());
                    return;
                };
                self.probe_pose = pose;
                self.evaluation.insert(narrow.begin(&pose))
            }
        };
        let Some(evaluation) = narrow.proceed(under_way, work) else { return };
        self.evaluation = None;
        self.stats.evaluations = self.stats.evaluations.saturating_add(1);
        let is_flat = evaluation.is_finite() && evaluation.error - from.evaluation.error < FLAT_RISE;
        if is_flat {
            let _ = self.polished.push(Found { pose: self.probe_pose, evaluation });
        }
        self.phase = Phase::Probe(if is_flat { probe.next_step() } else { probe.next_side() });
    }

    /// Where a step leads; `None` if the component is known exactly or the region ends before.
    fn probe_pose(&self, probe: Probe, from: &Found) -> Option<PlanarPose> {
        let axis = usize::from(probe.side / 2).min(2);
        let covariance = self.covariance(&from.evaluation);
        let sigma = libm::sqrtf(covariance[(axis, axis)]);
        if sigma <= 0.0 {
            return None;
        }
        let least = if axis < 2 { SAME_POSITION_M } else { SAME_YAW_RAD };
        let length = (FIRST_STEP_SIGMAS * sigma).max(least) * f32::from(1_u8 << probe.step);
        let signed = if probe.side.is_multiple_of(2) { length } else { -length };
        let mut pose = from.pose.to_array();
        for (component, value) in pose.iter_mut().enumerate() {
            *value += signed * covariance[(component, axis)] / covariance[(axis, axis)];
        }
        let (aimed, reached) = (pose[axis], self.bounds.clamp(&PlanarPose::from_array(pose)));
        // What the bounds cut off by more than half is no step of its own.
        (libm::fabsf(reached.to_array()[axis] - aimed) < 0.5 * length).then_some(reached)
    }
}
