//! What a phase works with during one tick.

use crate::controller::Outputs;
use crate::executor::Executor;
use crate::onset::{Felt, Onset};
use tactus_common::limits::{HAND_MOTORS, PADS};
use tactus_common::message::{PlanAnswer, RolloutResult};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::{HandCommand, JointReadings, TactileImage};

/// What a phase works with during one tick.
pub struct Tools<'a> {
    /// Where the robot's base stands.
    pub robot_base: PlanarPose,
    /// Readings of this tick.
    pub readings: &'a JointReadings,
    /// What is felt.
    pub felt: Felt,
    /// New images of the pads, by pad.
    pub images: &'a [Option<TactileImage>; PADS],
    /// Which hand links touch, bit i = link i, by an ideal sensor; `None` without one.
    pub links: Option<u16>,
    /// The planner's answer.
    pub plan: Option<&'a PlanAnswer>,
    /// The mental world's answer.
    pub rollout: Option<&'a RolloutResult>,
    /// Moves the arm.
    pub executor: &'a mut Executor,
    /// Contact detection.
    pub onset: &'a mut Onset,
    /// Commands of the hand; kept from tick to tick.
    pub hand: &'a mut [HandCommand; HAND_MOTORS],
    /// What goes out.
    pub out: &'a mut Outputs,
}
