//! Finger torques that hold the object, and how they are raised.

use tactus_common::limits::{FINGERS, HAND_MOTORS};
use tactus_common::reading::{HandCommand, JointReadings};
use tactus_common::robot::tables::TIP_TORQUE_RANGE_NM;

/// Torque of F1 and F2 while holding, Nm at the inner joint: about 6 N at each tip.
const PAIR_NM: f32 = 0.7;
/// Torque of F3, which stands against both.
const SINGLE_NM: f32 = 1.1;
/// What one step adds, as a share of the first grip.
const STEP_SHARE: f32 = 0.18;
/// Ticks to build up a grip: 0.4 s.
pub const SQUEEZE_TICKS: u32 = 200;
/// Most steps: F3 then pushes with 1.5 Nm, a third of its motor's continuous torque without losses (facts 2.4). A finger that has
/// broken away hands three quarters of it, less friction, to its tip, whose sensor ends at 1 Nm.
const STEPS_MAX: u8 = 2;
/// A fingertip torque from which on no step is added, Nm: the hand's own protection opens the finger at 1.14 Nm.
const TIP_MAX_NM: f32 = 0.9 * TIP_TORQUE_RANGE_NM;

/// How hard the fingers push.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Grip {
    steps: u8,
}

impl Grip {
    /// Adds a step; `false` if the motors or the fingertips are to push no harder.
    pub fn raise(&mut self, readings: &JointReadings) -> bool {
        let spare = readings.tip_torque_nm.iter().all(|tip_nm| *tip_nm < TIP_MAX_NM);
        let raised = self.steps < STEPS_MAX && spare;
        self.steps += u8::from(raised);
        raised
    }

    /// Torque of a finger at its inner joint, Nm.
    pub fn torque_nm(self, finger: usize) -> f32 {
        let first_nm = if finger == 2 { SINGLE_NM } else { PAIR_NM };
        first_nm * (1.0 + STEP_SHARE * f32::from(self.steps))
    }

    /// Commands the grip.
    pub fn command(self, hand: &mut [HandCommand; HAND_MOTORS]) {
        for (f, motor) in hand.iter_mut().enumerate().take(FINGERS) {
            *motor = HandCommand::Torque(self.torque_nm(f));
        }
    }
}
