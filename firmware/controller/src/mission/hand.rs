//! Small helpers that the phases share: where the hand is, and moving the fingers to a preshape.

use super::Tools;
use nalgebra::Isometry3;
use tactus_common::limits::{ARM_JOINTS, HAND_MOTORS};
use tactus_common::message::{FaultReason, Preshape};
use tactus_common::reading::{HandCommand, JointReadings};
use tactus_common::robot::arm;
use tactus_common::robot::hand::HandAngles;

/// A motor this close to its target has reached it, radians.
const REACHED_RAD: f32 = 0.02;

/// Pose of the hand in the world as measured.
pub fn pose(tools: &Tools) -> Isometry3<f32> {
    arm::hand_pose_from(&tools.robot_base, &tools.readings.arm_q_rad)
}

/// Pose of the hand and angles of its joints as measured.
pub fn measured(tools: &Tools) -> (Isometry3<f32>, HandAngles) {
    (pose(tools), HandAngles::from_readings(&tools.readings.motor_q_rad, &tools.readings.inner_q_rad))
}

/// Target of each motor, radians: F1, F2, F3, spread.
fn targets_rad(target: &Preshape) -> [f32; HAND_MOTORS] {
    let [f1, f2, f3] = target.inner_rad;
    [f1, f2, f3, target.spread_rad]
}

/// Motors that are not at their target.
fn stray(target: &Preshape, readings: &JointReadings) -> impl Iterator<Item = usize> {
    let is_near = |(target, measured): (f32, f32)| (measured - target).abs() < REACHED_RAD;
    let reached = targets_rad(target).into_iter().zip(readings.motor_q_rad).map(is_near);
    reached.enumerate().filter_map(|(motor, there)| (!there).then_some(motor))
}

/// Commands the preshape; `true` once it is reached.
pub fn preshape(target: &Preshape, tools: &mut Tools) -> bool {
    *tools.hand = targets_rad(target).map(HandCommand::Position);
    stray(target, tools.readings).next().is_none()
}

/// The fault that names the first motor that is not at its target; joints of the hand count on from the arm's.
pub fn astray(target: &Preshape, readings: &JointReadings) -> FaultReason {
    let motor = stray(target, readings).next().unwrap_or(0);
    FaultReason::Tracking((ARM_JOINTS + motor) as u8)
}
