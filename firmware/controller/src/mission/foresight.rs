//! The mental world's check of a belief: it foretells the last touch at the new belief, and what it foretells must be
//! what was felt.

use super::closing;
use crate::touch::TouchPlan;
use tactus_common::limits::{ARM_JOINTS, FINGERS};
use tactus_common::message::{RolloutRequest, RolloutResult};
use tactus_common::pose::PlanarPose;

/// Difference between foretold and felt inner-link angle at onset that still confirms the belief, radians (about 3 mm).
pub const CONFIRM_RAD: f32 = 0.03;
/// Ticks of closing that are foretold: 0.6 s.
const CONFIRM_TICKS: u16 = 300;
/// The foretold closing begins this much before the angle at which something was felt, radians: half of what 0.6 s
/// of closing sweep.
const CONFIRM_RUN_UP_RAD: f32 = 0.1;

/// What the last touch felt, for the mental world to foretell.
#[derive(Clone, Copy, Debug, Default)]
pub struct LastTouch {
    /// Arm angles during the closing, radians.
    pub arm_q_rad: [f32; ARM_JOINTS],
    /// What was tried; `None` before the first touch.
    pub plan: Option<TouchPlan>,
    /// Inner-link angle at onset per finger, radians.
    pub onset_inner_rad: [Option<f32>; FINGERS],
}

impl LastTouch {
    /// The question what it would have felt like at `pose`; without a contact there is nothing to ask.
    pub fn question(&self, pose: PlanarPose) -> Option<RolloutRequest> {
        let plan = self.plan.filter(|_| self.onset_inner_rad.iter().any(Option::is_some))?;
        // The fingers that felt something close once more from shortly before: the rollout is as short as that.
        let mut preshape = plan.preshape();
        let mut closing_rad_s = [0.0; FINGERS];
        for ((onset, inner_rad), speed) in
            self.onset_inner_rad.iter().zip(&mut preshape.inner_rad).zip(&mut closing_rad_s)
        {
            if let Some(onset_rad) = onset {
                *inner_rad = (onset_rad - CONFIRM_RUN_UP_RAD).max(*inner_rad);
                *speed = closing::CLOSING_RAD_S;
            }
        }
        Some(RolloutRequest {
            request: 0,
            pose,
            arm_q_rad: self.arm_q_rad,
            preshape,
            closing_rad_s,
            ticks: CONFIRM_TICKS,
        })
    }

    /// Is what the mental world foretells what was felt?
    pub fn agrees(&self, foretold: &RolloutResult) -> bool {
        self.onset_inner_rad.iter().zip(&foretold.onset_inner_rad).all(|pair| match pair {
            (Some(felt), Some(foretold)) => (felt - foretold).abs() <= CONFIRM_RAD,
            (Some(_), None) => false,
            // Whether a finger just misses or just touches decides nothing.
            (None, _) => true,
        })
    }
}
