//! What the world, or the robot's gateway, says.

use super::packed::{ANGLE_LSB_RAD, EFFORT_LSB_NM, TIP_LSB_NM, pack_i16, pack_i24, unpack_i16, unpack_i24};
use crate::limits::{ARM_JOINTS, FINGERS, HAND_LINKS, HAND_MOTORS, OBSTACLES_MAX, PAD_CELLS, PADS};
use crate::method::Method;
use crate::pose::{Interval, PlanarPose};
use crate::reading::{JointReadings, TactileImage, Validity};
use crate::shape::{ObjectShape, Obstacle};
use crate::trajectory::Trajectory;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The mission: what the controller is told before the first tick. All it ever learns about the object's
/// place, except by touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Setup {
    /// The sender's [`SCHEMA_VERSION`](super::SCHEMA_VERSION), little-endian.
    pub schema_version: [u8; 8],
    /// What the object is.
    pub shape: ObjectShape,
    /// Guess of the object's pose in the world frame.
    pub guess: PlanarPose,
    /// The true pose lies within guess +- interval.
    pub interval: Interval,
    /// What else stands on the table, and where.
    pub obstacles: [Option<Obstacle>; OBSTACLES_MAX],
    /// Where to put it: displacement from where it stands, world x and y, metres.
    pub displacement_m: [f32; 2],
    /// Mass of the object as the mental model knows it, kilograms.
    pub mass_kg: f32,
    /// Most touches before the mission gives up.
    pub trials_max: u8,
    /// Where the robot's base stands, on the table's level: its frame's pose in the world.
    pub robot_base: PlanarPose,
    /// How the pose is to be found.
    pub method: Method,
}

/// [`JointReadings`] on the wire: 63 bytes, one CAN FD frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct SensorFrame {
    tick: [u8; 4],
    arm: [[u8; 3]; ARM_JOINTS],
    motors: [[u8; 3]; HAND_MOTORS],
    inner: [[u8; 3]; FINGERS],
    efforts: [[u8; 2]; HAND_MOTORS],
    tips: [[u8; 2]; FINGERS],
    valid: [u8; 3],
}

impl SensorFrame {
    /// Bytes on the wire.
    pub const WIRE_LEN: usize = 63;

    /// Packs readings; a value that is not finite is sent as not measured.
    pub fn pack(r: &JointReadings) -> Self {
        let mut valid = r.valid.0;
        let values = r.arm_q_rad.iter().chain(&r.motor_q_rad).chain(&r.inner_q_rad);
        for (bit, value) in values.chain(&r.effort_nm).chain(&r.tip_torque_nm).enumerate() {
            if !value.is_finite() {
                valid &= !(1 << bit);
            }
        }
        let [v0, v1, v2, _] = valid.to_le_bytes();
        Self {
            tick: r.tick.to_le_bytes(),
            arm: r.arm_q_rad.map(|q| pack_i24(q, ANGLE_LSB_RAD)),
            motors: r.motor_q_rad.map(|q| pack_i24(q, ANGLE_LSB_RAD)),
            inner: r.inner_q_rad.map(|q| pack_i24(q, ANGLE_LSB_RAD)),
            efforts: r.effort_nm.map(|t| pack_i16(t, EFFORT_LSB_NM)),
            tips: r.tip_torque_nm.map(|t| pack_i16(t, TIP_LSB_NM)),
            valid: [v0, v1, v2],
        }
    }

    /// The readings, SI units.
    pub fn unpack(&self) -> JointReadings {
        let [v0, v1, v2] = self.valid;
        JointReadings {
            tick: u32::from_le_bytes(self.tick),
            arm_q_rad: self.arm.map(|q| unpack_i24(q, ANGLE_LSB_RAD)),
            motor_q_rad: self.motors.map(|q| unpack_i24(q, ANGLE_LSB_RAD)),
            inner_q_rad: self.inner.map(|q| unpack_i24(q, ANGLE_LSB_RAD)),
            effort_nm: self.efforts.map(|t| unpack_i16(t, EFFORT_LSB_NM)),
            tip_torque_nm: self.tips.map(|t| unpack_i16(t, TIP_LSB_NM)),
            valid: Validity(u32::from_le_bytes([v0, v1, v2, 0]) & Validity::ALL.0),
        }
    }
}

/// [`TactileImage`] on the wire: 24 cells of 12 bits, two cells in three bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct TactileSlice {
    effective: [u8; 4],
    stamp: [u8; 4],
    pad: u8,
    cells: [[u8; 3]; PAD_CELLS / 2],
}

impl TactileSlice {
    /// Packs an image that takes effect at tick `effective`; pressures saturate at 12 bits of 1/256 N/cm^2.
    pub fn pack(image: &TactileImage, effective: u32) -> Self {
        let code = |p: f32| libm::roundf(p * 256.0).clamp(0.0, 4095.0) as u16;
        let mut cells = [[0; 3]; PAD_CELLS / 2];
        for (out, pair) in cells.iter_mut().zip(image.pressure_n_cm2.chunks_exact(2)) {
            let [a, b] = [code(pair[0]), code(pair[1])];
            *out = [a as u8, (a >> 8) as u8 | (b << 4) as u8, (b >> 4) as u8];
        }
        Self { effective: effective.to_le_bytes(), stamp: image.stamp.to_le_bytes(), pad: image.pad, cells }
    }

    /// The image, or `None` if it names a pad that the hand does not have.
    pub fn unpack(&self) -> Option<TactileImage> {
        if usize::from(self.pad) >= PADS {
            return None;
        }
        let mut pressure_n_cm2 = [0.0; PAD_CELLS];
        for (pair, raw) in pressure_n_cm2.chunks_exact_mut(2).zip(&self.cells) {
            let a = u16::from(raw[0]) | (u16::from(raw[1] & 0x0f) << 8);
            let b = u16::from(raw[1] >> 4) | (u16::from(raw[2]) << 4);
            pair[0] = f32::from(a) / 256.0;
            pair[1] = f32::from(b) / 256.0;
        }
        Some(TactileImage { pad: self.pad, stamp: u32::from_le_bytes(self.stamp), pressure_n_cm2 })
    }

    /// Tick from which the controller uses it.
    pub fn effective(&self) -> u32 {
        u32::from_le_bytes(self.effective)
    }
}

/// Which hand links touch something, as an ideal sensor tells it that the real hand lacks: 10 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct LinkContact {
    effective: [u8; 4],
    stamp: [u8; 4],
    links: [u8; 2],
}

impl LinkContact {
    /// Packs what was felt at tick `stamp` to take effect at tick `effective`; bit i of `links` is hand link i
    /// ([`crate::robot::HandLink`]), bits beyond the nine links are left out.
    pub fn pack(links: u16, stamp: u32, effective: u32) -> Self {
        let links = (links & Self::LINKS).to_le_bytes();
        Self { effective: effective.to_le_bytes(), stamp: stamp.to_le_bytes(), links }
    }

    /// Bytes on the wire.
    pub const WIRE_LEN: usize = 10;
    /// The bits that stand for links.
    const LINKS: u16 = (1 << HAND_LINKS) - 1;

    /// Which links touch: bit i is hand link i.
    pub fn links(&self) -> u16 {
        u16::from_le_bytes(self.links) & Self::LINKS
    }

    /// Tick at which it was felt.
    pub fn stamp(&self) -> u32 {
        u32::from_le_bytes(self.stamp)
    }

    /// Tick from which the controller uses it.
    pub fn effective(&self) -> u32 {
        u32::from_le_bytes(self.effective)
    }
}

/// Why the planner has no trajectory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum RefusalReason {
    /// No joint angles within the limits put the hand there.
    NoInverseKinematics,
    /// The goal is beyond the arm's reach.
    OutOfReach,
    /// The robot is in collision where it stands.
    StartInCollision,
    /// The robot would be in collision at the goal.
    GoalInCollision,
    /// The search found no collision-free path.
    NoPath,
    /// The path needs more knots than a trajectory holds.
    TooManyKnots,
    /// The request holds a value that is not finite.
    NonFinite,
}

/// The planner's answer to a [`PlanRequest`](super::PlanRequest).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct PlanAnswer {
    /// Tick from which the controller uses it.
    pub effective: u32,
    /// The request that this answers.
    pub request: u16,
    /// The trajectory, or why there is none.
    pub result: Result<Trajectory, RefusalReason>,
}

/// Instants of a predicted contact matrix.
pub const ROLLOUT_INSTANTS: usize = 16;

/// What the mental world foretells for a [`RolloutRequest`](super::RolloutRequest).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct RolloutResult {
    /// Tick from which the controller uses it.
    pub effective: u32,
    /// The request that this answers.
    pub request: u16,
    /// Per finger: inner-link angle at first contact, radians, if it touches at all.
    pub onset_inner_rad: [Option<f32>; FINGERS],
    /// Which of the nine hand links have touched by then, bit i = link i, at [`ROLLOUT_INSTANTS`] equally spaced instants of
    /// [`RolloutRequest::ticks`](super::RolloutRequest::ticks), the last at their end.
    pub contacts: [u16; ROLLOUT_INSTANTS],
}
