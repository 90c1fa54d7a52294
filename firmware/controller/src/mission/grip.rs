//! Finger torques that hold the object.

use tactus_common::limits::{FINGERS, HAND_MOTORS};
use tactus_common::reading::HandCommand;

/// Torque of F1 and F2 while holding, Nm at the inner joint: about 6 N at each tip.
const PAIR_NM: f32 = 0.7;
/// Torque of F3, which stands against both.
const SINGLE_NM: f32 = 1.1;

/// Commands the grip.
pub fn squeeze(hand: &mut [HandCommand; HAND_MOTORS]) {
    for (f, motor) in hand.iter_mut().enumerate().take(FINGERS) {
        *motor = HandCommand::Torque(if f == 2 { SINGLE_NM } else { PAIR_NM });
    }
}
