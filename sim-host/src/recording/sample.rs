//! The messages of a recording that have no standard type: JSON objects, one struct each. Field names carry quantity and
//! unit; the schema in the file carries these texts.
//!
//! Orders: arm J1..J7; hand motors F1, F2, F3, spread; fingers F1, F2, F3; hand links palm, F1 knuckle, F1 inner, F1 tip,
//! F2 knuckle, F2 inner, F2 tip, F3 inner, F3 tip.

use crate::host::Lost;
use crate::mission::{planar, tilt_rad};
use crate::wire::WireStats;
use crate::world::model::Cell;
use nalgebra::{Isometry3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_LINKS, HAND_MOTORS, PAD_CELLS};
use tactus_common::message::{self, DigestReport, Outcome, Phase, RefusalReason};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::{HandCommand, JointCommands, JointReadings, TactileImage};
use tactus_common::shape::ObjectShape;

/// Pose of an object that stands on the table, world frame (z up, origin on the table top's centre).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Planar {
    /// World x of the object's frame, metres.
    pub x_m: f32,
    /// World y of the object's frame, metres.
    pub y_m: f32,
    /// Turn about the world's z, anticlockwise from above, radians.
    pub phi_rad: f32,
}

impl From<PlanarPose> for Planar {
    fn from(p: PlanarPose) -> Self {
        Self { x_m: p.x_m, y_m: p.y_m, phi_rad: p.phi_rad }
    }
}

impl From<Planar> for PlanarPose {
    fn from(p: Planar) -> Self {
        Self::new(p.x_m, p.y_m, p.phi_rad)
    }
}

/// Covariance of a planar pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Covariance {
    /// Variance of x, m^2.
    pub xx_m2: f32,
    /// Covariance of x and y, m^2.
    pub xy_m2: f32,
    /// Covariance of x and phi, m rad.
    pub xphi_m_rad: f32,
    /// Variance of y, m^2.
    pub yy_m2: f32,
    /// Covariance of y and phi, m rad.
    pub yphi_m_rad: f32,
    /// Variance of phi, rad^2.
    pub phiphi_rad2: f32,
}

impl From<[f32; 6]> for Covariance {
    fn from([xx_m2, xy_m2, xphi_m_rad, yy_m2, yphi_m_rad, phiphi_rad2]: [f32; 6]) -> Self {
        Self { xx_m2, xy_m2, xphi_m_rad, yy_m2, yphi_m_rad, phiphi_rad2 }
    }
}

/// Readings of one tick, as they were sent to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Joints {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Arm joint angles J1..J7, radians.
    pub arm_q_rad: [f32; ARM_JOINTS],
    /// Hand motor positions as joint angles F1, F2, F3, spread, radians.
    pub motor_q_rad: [f32; HAND_MOTORS],
    /// Inner-link angles F1, F2, F3 by the secondary encoders, radians.
    pub inner_q_rad: [f32; FINGERS],
    /// Hand motor efforts at the joint F1, F2, F3, spread, newton-metres, positive = closing.
    pub effort_nm: [f32; HAND_MOTORS],
    /// Fingertip torques F1, F2, F3 (strain gauges), newton-metres, positive = the world pushes the tip open.
    pub tip_torque_nm: [f32; FINGERS],
    /// Which were measured: bits 0-6 arm, 7-10 motors, 11-13 inner links, 14-17 efforts, 18-20 tips.
    pub valid_bits: u32,
}

impl From<&JointReadings> for Joints {
    fn from(r: &JointReadings) -> Self {
        Self {
            tick: r.tick,
            arm_q_rad: r.arm_q_rad,
            motor_q_rad: r.motor_q_rad,
            inner_q_rad: r.inner_q_rad,
            effort_nm: r.effort_nm,
            tip_torque_nm: r.tip_torque_nm,
            valid_bits: r.valid.0,
        }
    }
}

/// Image of one tactile pad, as it was sent to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Tactile {
    /// Tick of 2 ms at which the pad was scanned.
    pub tick: u32,
    /// 0, 1, 2 = fingertips F1, F2, F3; 3 = palm.
    pub pad: u8,
    /// Pressure per cell, N/cm^2, in the order of the cells in /sensors/pads.
    pub pressure_n_cm2: [f32; PAD_CELLS],
}

impl From<&TactileImage> for Tactile {
    fn from(image: &TactileImage) -> Self {
        Self { tick: image.stamp, pad: image.pad, pressure_n_cm2: image.pressure_n_cm2 }
    }
}

/// What the ideal contact sensors feel, as it was sent to the controller; the real hand lacks them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LinkContacts {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Is it touched: palm, F1 knuckle, F1 inner, F1 tip, F2 knuckle, F2 inner, F2 tip, F3 inner, F3 tip.
    pub touched: [bool; HAND_LINKS],
}

impl LinkContacts {
    /// Bit i of `links` is hand link i.
    pub fn new(tick: u32, links: u16) -> Self {
        Self { tick, touched: core::array::from_fn(|i| links >> i & 1 == 1) }
    }
}

/// A vector in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Xyz {
    /// Along the frame's x.
    pub x: f32,
    /// Along the frame's y.
    pub y: f32,
    /// Along the frame's z.
    pub z: f32,
}

impl From<[f32; 3]> for Xyz {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<Xyz> for Vector3<f32> {
    fn from(v: Xyz) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

/// Where the cells of a tactile pad are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pad {
    /// 0, 1, 2 = fingertips F1, F2, F3; 3 = palm.
    pub pad: u8,
    /// Frame of the link that carries it, in /tf.
    pub frame_id: String,
    /// Cells' centres in that frame, metres.
    pub centre_m: Vec<Xyz>,
    /// Outward normals of the cells in that frame, unit length.
    pub normal: Vec<Xyz>,
    /// Areas of the cells, m^2.
    pub area_m2: Vec<f32>,
}

impl Pad {
    /// The pad with these cells on the link of this frame.
    pub fn new(pad: usize, frame_id: &str, cells: &[Cell]) -> Self {
        Self {
            pad: pad as u8,
            frame_id: frame_id.to_owned(),
            centre_m: cells.iter().map(|cell| cell.centre_m.to_array().into()).collect(),
            normal: cells.iter().map(|cell| cell.normal.to_array().into()).collect(),
            area_m2: cells.iter().map(|cell| cell.area_m2).collect(),
        }
    }
}

/// Where the tactile cells are; once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pads {
    /// Tick of 2 ms.
    pub tick: u32,
    /// The pads.
    pub pads: Vec<Pad>,
}

/// What a hand motor is told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HandMode {
    /// No current.
    Idle,
    /// Move to an angle and hold it; the value is in radians.
    Position,
    /// Move at a speed; the value is in rad/s, positive = closing.
    Velocity,
    /// Push with a torque; the value is in newton-metres, positive = closing.
    Torque,
}

/// The controller's command in answer to one tick's readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Command {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Arm joint torques J1..J7, newton-metres.
    pub arm_tau_nm: [f32; ARM_JOINTS],
    /// What the hand motors F1, F2, F3, spread are to do: idle, position (rad), velocity (rad/s) or torque (N m).
    pub hand_mode: [HandMode; HAND_MOTORS],
    /// The value for each, in the unit of its mode, at the joint; 0 if idle.
    pub hand_value: [f32; HAND_MOTORS],
}

impl From<&JointCommands> for Command {
    fn from(commands: &JointCommands) -> Self {
        let hand = commands.hand.map(|command| match command {
            HandCommand::Idle => (HandMode::Idle, 0.0),
            HandCommand::Position(value) => (HandMode::Position, value),
            HandCommand::Velocity(value) => (HandMode::Velocity, value),
            HandCommand::Torque(value) => (HandMode::Torque, value),
        });
        Self {
            tick: commands.tick,
            arm_tau_nm: commands.arm_tau_nm,
            hand_mode: hand.map(|(mode, _)| mode),
            hand_value: hand.map(|(_, value)| value),
        }
    }
}

/// What the controller thinks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Status {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Phase of the mission: Initialise, Plan, Trial, Update, Grasp, Transport, Release, Done, Failed or Fault.
    pub phase: String,
    /// Believed pose of the object.
    pub belief: Planar,
    /// Its covariance.
    pub covariance: Covariance,
    /// Evidence items held.
    pub evidence_count: u8,
    /// Touches done.
    pub touch_count: u8,
}

impl From<&message::Status> for Status {
    fn from(status: &message::Status) -> Self {
        Self {
            tick: status.tick,
            phase: format!("{:?}", status.phase),
            belief: status.belief.into(),
            covariance: status.covariance.into(),
            evidence_count: status.evidence,
            touch_count: status.touches,
        }
    }
}

/// A phase of the mission began.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PhaseBegun {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Initialise, Plan, Trial, Update, Grasp, Transport, Release, Done, Failed or Fault.
    pub phase: String,
}

impl PhaseBegun {
    /// This phase began at this tick.
    pub fn new(tick: u32, phase: Phase) -> Self {
        Self { tick, phase: format!("{phase:?}") }
    }
}

/// A touch began.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Touch {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Index of the candidate touch.
    pub candidate: u8,
    /// Information that it is expected to give, nats.
    pub information_nats: f32,
}

/// The hand felt something, as the controller says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contact {
    /// Tick of 2 ms.
    pub tick: u32,
    /// 0, 1, 2 = F1, F2, F3; 3 = palm.
    pub finger: u8,
    /// Inner-link angle at that moment, radians.
    pub inner_rad: f32,
    /// Felt while the hand came down, not while it closed.
    pub descending: bool,
}

/// The belief was corrected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Update {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Believed pose of the object.
    pub belief: Planar,
    /// Its covariance.
    pub covariance: Covariance,
    /// Error evaluations of this update.
    pub evaluations: u16,
    /// Distinct poses that explain the evidence.
    pub modes: u8,
    /// The next step is the grasp.
    pub confident: bool,
}

/// The mental world was asked what a touch at the belief would feel like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Foretold {
    /// Tick of 2 ms.
    pub tick: u32,
    /// It foretells what was felt.
    pub agrees: bool,
}

/// The planner refused a motion.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Refusal {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Why.
    pub reason: String,
}

impl Refusal {
    /// Refused at this tick for this reason.
    pub fn new(tick: u32, reason: RefusalReason) -> Self {
        Self { tick, reason: format!("{reason:?}") }
    }
}

/// The object slips in the hand, as the controller feels it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Slip {
    /// Tick of 2 ms.
    pub tick: u32,
    /// The finger that feels it most: 0, 1, 2 = F1, F2, F3.
    pub finger: u8,
    /// How sure that is, 0.5 to 1.
    pub sureness: f32,
    /// What that finger is to push with from now on, newton-metres at its inner joint.
    pub grip_nm: f32,
}

/// The mission ended, as the controller says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct End {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Transported, Failed(reason) or Fault(reason).
    pub outcome: String,
    /// Digest of the controller's inputs and outputs, 16 hexadecimal digits; empty if it did not arrive with the end.
    pub digest: String,
    /// Ticks that the digest covers.
    pub digest_ticks: u32,
}

impl End {
    /// Ended so at this tick, with this digest.
    pub fn new(tick: u32, outcome: Outcome, digest: Option<DigestReport>) -> Self {
        Self {
            tick,
            outcome: format!("{outcome:?}"),
            digest: digest.map(|d| format!("{:016x}", u64::from_le_bytes(d.digest))).unwrap_or_default(),
            digest_ticks: digest.map_or(0, |d| d.ticks),
        }
    }
}

/// The controller stopped answering.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ControllerLost {
    /// Tick of 2 ms at which it was given up.
    pub tick: u32,
    /// First tick without a command.
    pub since_tick: u32,
    /// Phase in which the mission was.
    pub phase: String,
}

impl ControllerLost {
    /// Given up at this tick.
    pub fn new(tick: u32, lost: &Lost) -> Self {
        Self { tick, since_tick: lost.tick, phase: format!("{:?}", lost.phase) }
    }
}

/// What the bus has carried and suffered so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Bus {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Frames, both ways, since the start.
    pub frames: u64,
    /// Largest share of busy time in any 100 ms so far, 0..1, as of a bus at 500 Hz.
    pub load_max: f32,
    /// Frames lost in queues since the start.
    pub lost: u64,
    /// Error frames, and frames that are none of ours, since the start.
    pub foreign: u64,
    /// Times at which the bus was down.
    pub downs: u64,
}

impl Bus {
    /// The figures at this tick.
    pub fn new(tick: u32, stats: &WireStats) -> Self {
        let WireStats { frames, load_max, lost, foreign, downs } = *stats;
        Self { tick, frames, load_max, lost, foreign, downs }
    }
}

/// Truth, which the controller never sees: pose of the object's frame (its centroid) in the world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectTruth {
    /// Tick of 2 ms.
    pub tick: u32,
    /// World x, metres.
    pub x_m: f32,
    /// World y, metres.
    pub y_m: f32,
    /// World z, metres.
    pub z_m: f32,
    /// Orientation as a unit quaternion x, y, z, w (world from object).
    pub orientation_xyzw: [f32; 4],
    /// Turn about the world's z, radians.
    pub phi_rad: f32,
    /// How far it leans from the vertical, radians.
    pub tilt_rad: f32,
}

impl ObjectTruth {
    /// The object, of this shape, stands so at this tick.
    pub fn new(tick: u32, shape: &ObjectShape, pose: &Isometry3<f32>) -> Self {
        let PlanarPose { x_m, y_m, phi_rad } = planar(pose);
        let tilt_rad = tilt_rad(shape, pose);
        let orientation_xyzw = pose.rotation.coords.into();
        Self { tick, x_m, y_m, z_m: pose.translation.z, orientation_xyzw, phi_rad, tilt_rad }
    }
}

/// Truth, which the controller never sees: normal force on each link of the hand over the last tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LinkForces {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Force on palm, F1 knuckle, F1 inner, F1 tip, F2 knuckle, F2 inner, F2 tip, F3 inner, F3 tip, newtons.
    pub force_n: [f32; HAND_LINKS],
}

/// Truth, which the controller never sees: how far its belief is from where the object stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BeliefError {
    /// Tick of 2 ms.
    pub tick: u32,
    /// Distance in the plane, metres.
    pub position_m: f32,
    /// Turn from the true yaw to the believed one, modulo the object's symmetry, radians.
    pub yaw_rad: f32,
}
