//! Questions to the mental world and its answers.

use crate::geometry::TactusPose;
use crate::handle::Plain;
use crate::plan::TactusPreshape;
use crate::robot::{TACTUS_ARM_JOINTS, TACTUS_FINGERS};
use tactus_common::message::{ROLLOUT_INSTANTS, RolloutRequest, RolloutResult};

/// A question to a simulation of the hand: what would this touch feel if the object stood at `pose`? It confirms the
/// belief before the grasp. Answer it with a `TactusRollout` in a later tick, within 10 s.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusRolloutRequest {
    /// Hypothesised pose of the object.
    pub pose: TactusPose,
    /// Arm joint angles during the touch, radians.
    pub arm_q_rad: [f32; TACTUS_ARM_JOINTS],
    /// Finger angles from which to close.
    pub preshape: TactusPreshape,
    /// Closing speed of each finger's inner link, rad/s, for `ticks`; 0 = does not close.
    pub closing_rad_s: [f32; TACTUS_FINGERS],
    /// Ticks of closing to foretell, 2 ms each.
    pub ticks: u16,
    /// Number of this request; the answer carries it.
    pub request: u16,
}

impl From<&RolloutRequest> for TactusRolloutRequest {
    fn from(r: &RolloutRequest) -> Self {
        Self {
            pose: r.pose.into(),
            arm_q_rad: r.arm_q_rad,
            preshape: r.preshape.into(),
            closing_rad_s: r.closing_rad_s,
            ticks: r.ticks,
            request: r.request,
        }
    }
}

/// What the simulation foretells.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusRollout {
    /// Inner-link angle at which each finger first touches, radians; not looked at where it touches nothing.
    pub onset_inner_rad: [f32; TACTUS_FINGERS],
    /// Which fingers touch: bits 0, 1, 2 = F1, F2, F3.
    pub touching: u8,
    /// Number of the request that this answers.
    pub request: u16,
}

// SAFETY: numbers only.
unsafe impl Plain for TactusRollout {}

impl TactusRollout {
    pub(crate) fn to_rust(self, now: u32) -> RolloutResult {
        let mut onset_inner_rad = [None; TACTUS_FINGERS];
        for (finger, onset) in onset_inner_rad.iter_mut().enumerate() {
            *onset = (self.touching >> finger & 1 == 1).then(|| self.onset_inner_rad[finger]);
        }
        // The contact matrix is for the host's reports; the mission compares onsets.
        RolloutResult { effective: now, request: self.request, onset_inner_rad, contacts: [0; ROLLOUT_INSTANTS] }
    }
}
