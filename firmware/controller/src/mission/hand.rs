//! Small helpers that the phases share: where the hand is, and moving the fingers to a preshape.

use super::Tools;
use nalgebra::Isometry3;
use tactus_common::limits::FINGERS;
use tactus_common::message::Preshape;
use tactus_common::reading::{HandCommand, JointReadings};
use tactus_common::robot::arm;
use tactus_common::robot::hand::HandAngles;

/// A motor this close to its target has reached it, radians.
const REACHED_RAD: f32 = 0.02;

/// Pose of the hand and angles of its joints as measured.
pub fn measured(readings: &JointReadings) -> (Isometry3<f32>, HandAngles) {
    (arm::hand_pose(&readings.arm_q_rad), HandAngles::from_readings(&readings.motor_q_rad, &readings.inner_q_rad))
}

/// Commands the preshape; `true` once it is reached.
pub fn preshape(target: &Preshape, tools: &mut Tools) -> bool {
    let mut reached = (tools.readings.motor_q_rad[FINGERS] - target.spread_rad).abs() < REACHED_RAD;
    for f in 0..FINGERS {
        tools.hand[f] = HandCommand::Position(target.inner_rad[f]);
        reached &= (tools.readings.motor_q_rad[f] - target.inner_rad[f]).abs() < REACHED_RAD;
    }
    tools.hand[FINGERS] = HandCommand::Position(target.spread_rad);
    reached
}
