//! What the controller says.

use super::RefusalReason;
use super::packed::{ARM_TORQUE_LSB_NM, HAND_VALUE_LSB, pack_i16, pack_i24, unpack_i16, unpack_i24};
use crate::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS};
use crate::pose::PlanarPose;
use crate::reading::{HandCommand, JointCommands};
use crate::robot::tables::PALM_FACE_Z_M;
use crate::shape::ObjectShape;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// [`JointCommands`] on the wire: 34 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Command {
    tick: [u8; 4],
    arm: [[u8; 2]; ARM_JOINTS],
    hand: [(u8, [u8; 3]); HAND_MOTORS],
}

impl Command {
    /// Bytes on the wire.
    pub const WIRE_LEN: usize = 34;

    /// Packs commands; a torque that is not finite is sent as 0, a hand value that is not finite as idle.
    pub fn pack(c: &JointCommands) -> Self {
        let hand = c.hand.map(|h| match h {
            HandCommand::Position(v) if v.is_finite() => (1, pack_i24(v, HAND_VALUE_LSB)),
            HandCommand::Velocity(v) if v.is_finite() => (2, pack_i24(v, HAND_VALUE_LSB)),
            HandCommand::Torque(v) if v.is_finite() => (3, pack_i24(v, HAND_VALUE_LSB)),
            HandCommand::Idle | HandCommand::Position(_) | HandCommand::Velocity(_) | HandCommand::Torque(_) => {
                (0, [0; 3])
            }
        });
        Self { tick: c.tick.to_le_bytes(), arm: c.arm_tau_nm.map(|t| pack_i16(t, ARM_TORQUE_LSB_NM)), hand }
    }

    /// The commands, or `None` if a hand mode is unknown.
    pub fn unpack(&self) -> Option<JointCommands> {
        let mut hand = [HandCommand::Idle; HAND_MOTORS];
        for (out, (mode, raw)) in hand.iter_mut().zip(self.hand) {
            let value = unpack_i24(raw, HAND_VALUE_LSB);
            *out = match mode {
                0 => HandCommand::Idle,
                1 => HandCommand::Position(value),
                2 => HandCommand::Velocity(value),
                3 => HandCommand::Torque(value),
                _ => return None,
            };
        }
        Some(JointCommands {
            tick: u32::from_le_bytes(self.tick),
            arm_tau_nm: self.arm.map(|t| unpack_i16(t, ARM_TORQUE_LSB_NM)),
            hand,
        })
    }
}

/// Where the hand goes, pointing straight down, relative to the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct HandPlacement {
    /// The hand's axis and yaw in the object's frame; at yaw 0 the hand's +x (the side of F1 and F2) is the
    /// object's +x.
    pub hand_in_object: PlanarPose,
    /// Height of the palm's face above the object's top, metres.
    pub palm_height_m: f32,
}

impl HandPlacement {
    /// World-from-hand transform for an object believed at `object`: z straight down.
    pub fn world_from_hand(&self, object: &PlanarPose, shape: &ObjectShape) -> Isometry3<f32> {
        let hand = object.compose(&self.hand_in_object);
        let z_m = shape.top_height_m() + self.palm_height_m + PALM_FACE_Z_M;
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), hand.phi_rad);
        // Half a turn about x: z down, y mirrored.
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f32::consts::PI);
        Isometry3::from_parts(Translation3::new(hand.x_m, hand.y_m, z_m), yaw * down)
    }
}

/// Finger joint angles before closing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Preshape {
    /// Inner-link angles F1, F2, F3, radians.
    pub inner_rad: [f32; FINGERS],
    /// Spread, radians.
    pub spread_rad: f32,
}

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Purpose {
    /// Come down beside the object to touch it.
    Touch,
    /// Come down over the object to grasp it.
    Grasp,
    /// Lift the grasped object, carry it by the displacement, set it down.
    Transport,
    /// Straight up and away.
    Retreat,
}

/// The controller asks the host for a trajectory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct PlanRequest {
    /// Number of this request; the answer carries it.
    pub request: u16,
    /// What the motion is for.
    pub purpose: Purpose,
    /// Candidate touch (index into the controller's list), 255 = none.
    pub touch: u8,
    /// Arm joint angles to start from, radians.
    pub start_q_rad: [f32; ARM_JOINTS],
    /// Where the hand is to go, relative to the believed object (`Touch`, `Grasp`).
    pub placement: HandPlacement,
    /// Finger angles on the way.
    pub preshape: Preshape,
    /// Displacement of the object in the world, metres: now (`Transport`), or next (`Grasp`).
    pub displacement_m: [f32; 2],
    /// Believed pose of the object.
    pub belief: PlanarPose,
    /// Upper triangle of its covariance: xx, xy, xphi, yy, yphi, phiphi (m^2, m rad, rad^2).
    pub covariance: [f32; 6],
}

/// The controller asks the mental world what a touch would feel like.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct RolloutRequest {
    /// Number of this request; the result carries it.
    pub request: u16,
    /// Hypothesised pose of the object.
    pub pose: PlanarPose,
    /// Arm joint angles during the touch, radians.
    pub arm_q_rad: [f32; ARM_JOINTS],
    /// Finger angles from which to close.
    pub preshape: Preshape,
    /// Closing speed of each finger's inner link, rad/s; 0 = does not close.
    pub closing_rad_s: [f32; FINGERS],
    /// Ticks of closing to foretell, at most [`ROLLOUT_TICKS_MAX`].
    pub ticks: u16,
}

/// Longest closing that a rollout foretells, ticks: 5 s.
pub const ROLLOUT_TICKS_MAX: u16 = 2_500;

/// Phase of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, Schema)]
pub enum Phase {
    /// Waits for its set-up and for the first readings.
    Initialise,
    /// Chooses the next touch and waits for a trajectory.
    Plan,
    /// Moves, comes down and closes the fingers, guarded.
    Trial,
    /// Fits the pose to all evidence.
    Update,
    /// Comes down over the object and takes it.
    Grasp,
    /// Carries it.
    Transport,
    /// Lets go and withdraws.
    Release,
    /// The object stands at its goal.
    Done,
    /// Gave up with the robot in its safe state.
    Failed,
    /// Something is wrong; the robot is in its safe state.
    Fault,
}

/// Why the mission gave up although nothing is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum FailureReason {
    /// The planner refused every candidate motion; its last reason.
    NoPlan(RefusalReason),
    /// The touches allowed did not make the pose certain enough to grasp.
    NotConfident,
    /// Nothing was felt where the object should be.
    NothingFelt,
    /// The fingers closed without holding the object.
    GraspMissed,
    /// The object was lost on the way.
    ObjectLost,
}

/// What made the controller stop the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum FaultReason {
    /// No sensor message for [`crate::limits::SILENCE_TICKS_MAX`] ticks.
    HostSilent,
    /// A needed reading was not measured (or not finite) for several ticks.
    SensorInvalid,
    /// A joint left its range.
    JointLimit(u8),
    /// A joint moved faster than its limit.
    JointSpeed(u8),
    /// A joint did not follow its reference: 0-6 the arm's J1 to J7, 7-10 the hand's F1, F2, F3 and spread.
    Tracking(u8),
    /// Set-up message with values that make no sense.
    BadSetup,
    /// Set-up message of another schema version.
    SchemaMismatch,
    /// The host did not answer a request in time.
    HostSlow,
    /// Set-up message that asks for an optimiser which is not compiled into this image.
    NotInImage,
}

/// How a mission ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Outcome {
    /// The object was put down at its goal, as far as the controller can tell.
    Transported,
    /// The task failed.
    Failed(FailureReason),
    /// The robot was made safe.
    Fault(FaultReason),
}

/// What the controller thinks, ten times a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Status {
    /// Tick.
    pub tick: u32,
    /// Phase of the mission.
    pub phase: Phase,
    /// Believed pose of the object.
    pub belief: PlanarPose,
    /// Upper triangle of its covariance, as in [`PlanRequest::covariance`].
    pub covariance: [f32; 6],
    /// Evidence items held.
    pub evidence: u8,
    /// Touches done.
    pub touches: u8,
}

/// Something happened.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Event {
    /// Tick.
    pub tick: u32,
    /// What.
    pub kind: EventKind,
}

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum EventKind {
    /// A phase began.
    Phase(Phase),
    /// A touch began: candidate index and expected information in nats.
    Touch {
        /// Candidate index.
        candidate: u8,
        /// Expected information, nats.
        information_nats: f32,
    },
    /// A finger felt something.
    Contact {
        /// 0, 1, 2 = F1, F2, F3; 3 = palm.
        finger: u8,
        /// Inner-link angle at that moment, radians.
        inner_rad: f32,
        /// `true` if it was felt while the hand came down.
        descending: bool,
    },
    /// The belief was corrected.
    Updated {
        /// Believed pose.
        belief: PlanarPose,
        /// Upper triangle of its covariance, as in [`PlanRequest::covariance`].
        covariance: [f32; 6],
        /// Error evaluations of this update.
        evaluations: u16,
        /// Distinct poses that explain the evidence.
        modes: u8,
        /// `true` if the next step is the grasp.
        confident: bool,
    },
    /// The mental world was asked and agreed (`true`) or not.
    Confirmed(bool),
    /// The planner refused a motion.
    Refused(RefusalReason),
    /// The mission ended.
    Finished(Outcome),
    /// The object slips in the hand.
    Slip {
        /// The finger that feels it most: 0, 1, 2 = F1, F2, F3.
        finger: u8,
        /// How sure that is, 0.5 to 1.
        sureness: f32,
        /// What that finger is to push with from now on, newton-metres at its inner joint; as before, if no grip is left
        /// to try and the object is brought back to where it stood.
        grip_nm: f32,
    },
}

/// The controller's digest of the run so far, sent with the end of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct DigestReport {
    /// Ticks covered.
    pub ticks: u32,
    /// The digest, little-endian.
    pub digest: [u8; 8],
}

/// A controller without a mission says that it is there, once a second. The one message that keeps its layout whatever
/// else changes, so that two programs of different versions can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Hello {
    /// [`SCHEMA_VERSION`](super::SCHEMA_VERSION) of the sender, little-endian.
    pub schema_version: [u8; 8],
}

/// Cyphal heartbeat (uavcan.node.Heartbeat.1.0): 7 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Heartbeat {
    /// Seconds since start, little-endian.
    pub uptime_s: [u8; 4],
    /// 0 nominal, 1 advisory, 2 caution, 3 warning.
    pub health: u8,
    /// 0 operational, 1 initialisation.
    pub mode: u8,
    /// Vendor-specific: the phase.
    pub vendor: u8,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_mode_that_is_unknown_refuses_the_whole_command() {
        let mut command = Command::pack(&JointCommands::idle(3));
        assert_eq!(command.unpack(), Some(JointCommands::idle(3)));
        command.hand[2].0 = 4;
        assert_eq!(command.unpack(), None);
    }
}
