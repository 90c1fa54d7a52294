//! What crosses the wire: one struct per message, its subject and priority, and the schema version.
//!
//! `docs/protocol.md` says who sends which, when, and what its loss means. Values that travel every tick are
//! packed in fixed-width integers, so that a message's length never depends on its data.

mod in_place;

use crate::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PAD_CELLS, PADS};
use crate::pose::{Interval, PlanarPose};
use crate::reading::{HandCommand, JointCommands, JointReadings, TactileImage, Validity};
use crate::robot::tables::PALM_FACE_Z_M;
use crate::shape::ObjectShape;
use crate::trajectory::Trajectory;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use postcard_schema::schema::NamedType;
use postcard_schema::{Schema, key::Key};
use serde::{Deserialize, Serialize};

/// A message: where it travels.
pub trait Message: Serialize + Schema {
    /// Cyphal subject (13 bits).
    const SUBJECT: u16;
    /// Cyphal priority, 0 = exceptional .. 7 = optional.
    const PRIORITY: u8;
}

/// What a sniffer or a page of documentation needs to know of a message.
#[derive(Clone, Copy, Debug)]
pub struct Described {
    /// Its type's name.
    pub name: &'static str,
    /// [`Message::SUBJECT`].
    pub subject: u16,
    /// [`Message::PRIORITY`].
    pub priority: u8,
    /// Its layout.
    pub schema: &'static NamedType,
}

macro_rules! messages {
    ($($(#[$doc:meta])* $type:ty => $subject:literal, $priority:literal;)*) => {
        $($(#[$doc])* impl Message for $type {
            const SUBJECT: u16 = $subject;
            const PRIORITY: u8 = $priority;
        })*
        /// Every message, world's first.
        pub const MESSAGES: &[Described] = &[$(Described {
            name: stringify!($type),
            subject: <$type as Message>::SUBJECT,
            priority: <$type as Message>::PRIORITY,
            schema: <$type as Schema>::SCHEMA,
        }),*];
        /// Version of everything on the wire: a hash over the schema of every message. Two programs whose
        /// versions differ must not talk; [`Setup`] carries it.
        pub const SCHEMA_VERSION: u64 = {
            let mut hash = FNV_OFFSET;
            $( hash = fold(hash, Key::for_path::<$type>(stringify!($type)).to_bytes()); )*
            hash
        };
    };
}

messages! {
    Setup => 1100, 3;
    SensorFrame => 1101, 1;
    TactileSlice => 1102, 3;
    PlanAnswer => 1104, 4;
    RolloutResult => 1105, 4;
    Command => 1200, 1;
    PlanRequest => 1201, 4;
    RolloutRequest => 1202, 4;
    Status => 1203, 5;
    Event => 1204, 3;
    DigestReport => 1205, 5;
    Hello => 1206, 5;
    Heartbeat => 7509, 4;
}

const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

const fn fold(mut hash: u64, bytes: [u8; 8]) -> u64 {
    let mut i = 0;
    while i < 8 {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(FNV_PRIME);
        i += 1;
    }
    hash
}

/// FNV-1a-64 over the bytes of messages: the digest of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Self(FNV_OFFSET)
    }
}

impl Digest {
    /// Adds bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.add(b);
        }
    }

    /// Adds one byte.
    pub fn add(&mut self, byte: u8) {
        self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(FNV_PRIME);
    }
}

/// The wire's node ids (Cyphal, 7 bits).
pub mod node {
    /// The world or the robot's gateway.
    pub const WORLD: u8 = 10;
    /// The controller.
    pub const CONTROLLER: u8 = 20;
}

// ---------------------------------------------------------------------------------------------------------
// Fixed-width numbers

/// Angle resolution on the wire: 1 microradian in 24 bits, so +-8.38 rad.
const ANGLE_LSB_RAD: f32 = 1e-6;
/// Arm torque resolution: 1/256 Nm in 16 bits, so +-128 Nm (J2's mechanical limit is 109.5).
const ARM_TORQUE_LSB_NM: f32 = 1.0 / 256.0;
/// Hand effort resolution: 1 mNm in 16 bits, so +-32.7 Nm.
const EFFORT_LSB_NM: f32 = 1e-3;
/// Fingertip torque resolution: 50 uNm in 16 bits, so +-1.64 Nm (the strain gauge ends at 1.14).
const TIP_LSB_NM: f32 = 5e-5;
/// Hand command value resolution: 1e-6 rad, rad/s or Nm in 24 bits, so +-8.38.
const HAND_VALUE_LSB: f32 = 1e-6;

const I24_MAX: f32 = 8_388_607.0;

/// Nearest multiple of `lsb`, saturated to 24 bits, little-endian. NaN packs as 0.
fn pack_i24(value: f32, lsb: f32) -> [u8; 3] {
    let counts = libm::roundf(value / lsb).clamp(-I24_MAX, I24_MAX) as i32;
    let [a, b, c, _] = counts.to_le_bytes();
    [a, b, c]
}

fn unpack_i24(raw: [u8; 3], lsb: f32) -> f32 {
    let sign = if raw[2] & 0x80 != 0 { 0xff } else { 0 };
    i32::from_le_bytes([raw[0], raw[1], raw[2], sign]) as f32 * lsb
}

fn pack_i16(value: f32, lsb: f32) -> [u8; 2] {
    (libm::roundf(value / lsb).clamp(-32_767.0, 32_767.0) as i16).to_le_bytes()
}

fn unpack_i16(raw: [u8; 2], lsb: f32) -> f32 {
    f32::from(i16::from_le_bytes(raw)) * lsb
}

// ---------------------------------------------------------------------------------------------------------
// World to controller

/// The mission: what the controller is told before the first tick. All it ever learns about the object's
/// place, except by touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Setup {
    /// The sender's [`SCHEMA_VERSION`], little-endian.
    pub schema_version: [u8; 8],
    /// What the object is.
    pub shape: ObjectShape,
    /// Guess of the object's pose in the world frame.
    pub guess: PlanarPose,
    /// The true pose lies within guess +- interval.
    pub interval: Interval,
    /// Where to put it: displacement from where it stands, world x and y, metres.
    pub displacement_m: [f32; 2],
    /// Mass of the object as the mental model knows it, kilograms.
    pub mass_kg: f32,
    /// Most touches before the mission gives up.
    pub trials_max: u8,
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

/// The planner's answer to a [`PlanRequest`].
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

/// What the mental world foretells for a [`RolloutRequest`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct RolloutResult {
    /// Tick from which the controller uses it.
    pub effective: u32,
    /// The request that this answers.
    pub request: u16,
    /// Per finger: inner-link angle at first contact, radians, if it touches at all.
    pub onset_inner_rad: [Option<f32>; FINGERS],
    /// Contact bits of the nine hand links at [`ROLLOUT_INSTANTS`] equally spaced instants of [`ROLLOUT_TICKS`].
    pub contacts: [u16; ROLLOUT_INSTANTS],
}

// ---------------------------------------------------------------------------------------------------------
// Controller to world

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
}

/// Ticks of closing that a rollout foretells: 0.6 s.
pub const ROLLOUT_TICKS: u32 = 300;

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
    /// [`SCHEMA_VERSION`] of the sender, little-endian.
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
mod tests;
