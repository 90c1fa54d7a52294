//! The mission as C tells it, and how it ends.

use crate::geometry::{TactusInterval, TactusPose, TactusShape};
use crate::handle::Plain;
use crate::plan::TactusRefusal;
use crate::result::TactusResult;
use tactus_common::limits::OBSTACLES_MAX;
use tactus_common::message::{FailureReason, FaultReason, Outcome, Phase, SCHEMA_VERSION, Setup};
use tactus_common::method::Method;
use tactus_common::robot::MOUNT;

/// A mission: all that the controller is told about the object's place; the rest it must feel. The robot's base stands where
/// the robot's description has it: world x = -0.05 m, y = -0.6 m, yaw = pi/2.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusSetup {
    /// What the object is.
    pub shape: TactusShape,
    /// Guess of the object's pose.
    pub guess: TactusPose,
    /// The true pose lies within guess +- interval.
    pub interval: TactusInterval,
    /// Where to put it: displacement from where it stands, world x and y, metres.
    pub displacement_m: [f32; 2],
    /// Mass of the object, kilograms.
    pub mass_kg: f32,
    /// Most touches before the mission gives up, 1 or more.
    pub trials_max: u8,
}

// SAFETY: numbers only.
unsafe impl Plain for TactusSetup {}

impl TactusSetup {
    pub(crate) fn to_rust(self) -> Result<Setup, TactusResult> {
        Ok(Setup {
            schema_version: SCHEMA_VERSION.to_le_bytes(),
            shape: self.shape.to_rust()?,
            guess: self.guess.to_rust(),
            interval: self.interval.to_rust(),
            obstacles: [None; OBSTACLES_MAX],
            displacement_m: self.displacement_m,
            mass_kg: self.mass_kg,
            trials_max: self.trials_max,
            robot_base: MOUNT,
            method: Method::default(),
        })
    }
}

/// Phase of the mission.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusPhase {
    /// Waits for a mission and for the first readings.
    Initialise = 0,
    /// Chooses the next touch and waits for a trajectory.
    Plan = 1,
    /// Moves, comes down and closes the fingers, guarded.
    Trial = 2,
    /// Fits the pose to all evidence.
    Update = 3,
    /// Comes down over the object and takes it.
    Grasp = 4,
    /// Carries it.
    Transport = 5,
    /// Lets go and withdraws.
    Release = 6,
    /// The object stands at its goal.
    Done = 7,
    /// Gave up with the robot in its safe state.
    Failed = 8,
    /// Something is wrong; the robot is in its safe state.
    Fault = 9,
}

impl From<Phase> for TactusPhase {
    fn from(phase: Phase) -> Self {
        match phase {
            Phase::Initialise => Self::Initialise,
            Phase::Plan => Self::Plan,
            Phase::Trial => Self::Trial,
            Phase::Update => Self::Update,
            Phase::Grasp => Self::Grasp,
            Phase::Transport => Self::Transport,
            Phase::Release => Self::Release,
            Phase::Done => Self::Done,
            Phase::Failed => Self::Failed,
            Phase::Fault => Self::Fault,
        }
    }
}

/// How a mission ended.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusEnd {
    /// It has not ended.
    NotYet = 0,
    /// The object was put down at its goal, as far as the controller can tell.
    Transported = 1,
    /// The task failed; `failure` says why.
    Failed = 2,
    /// The robot was made safe; `fault` says why.
    Fault = 3,
}

/// Why a mission gave up although nothing is broken.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusFailure {
    /// It did not.
    None = 0,
    /// The planner refused every motion; `refusal` is its last reason.
    NoPlan = 1,
    /// The touches allowed did not make the pose certain enough to grasp.
    NotConfident = 2,
    /// Nothing was felt where the object should be.
    NothingFelt = 3,
    /// The fingers closed without holding the object.
    GraspMissed = 4,
    /// The object was lost on the way.
    ObjectLost = 5,
}

/// What made the controller stop the robot.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusFault {
    /// Nothing did.
    None = 0,
    /// No readings for `TACTUS_SILENCE_TICKS_MAX` ticks.
    HostSilent = 1,
    /// A needed reading was not measured (or not finite) for several ticks.
    SensorInvalid = 2,
    /// `joint` left its range.
    JointLimit = 3,
    /// `joint` moved faster than its limit.
    JointSpeed = 4,
    /// `joint` did not follow its reference.
    Tracking = 5,
    /// The mission makes no sense.
    BadSetup = 6,
    /// The mission is of another version of the wire's messages; cannot happen through this interface.
    SchemaMismatch = 7,
    /// A request was not answered within 10 s.
    HostSlow = 8,
    /// The mission asks for what is not compiled in; cannot happen with this library.
    NotInImage = 9,
}

/// How a mission ended, and why.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TactusOutcome {
    /// How.
    pub end: TactusEnd,
    /// Why it failed.
    pub failure: TactusFailure,
    /// Why there was no plan.
    pub refusal: TactusRefusal,
    /// What was wrong.
    pub fault: TactusFault,
    /// The arm joint that the fault is about, 0..6; else 255.
    pub joint: u8,
}

impl TactusOutcome {
    pub(crate) const NOT_YET: Self = Self {
        end: TactusEnd::NotYet,
        failure: TactusFailure::None,
        refusal: TactusRefusal::None,
        fault: TactusFault::None,
        joint: u8::MAX,
    };
}

impl From<Option<Outcome>> for TactusOutcome {
    fn from(outcome: Option<Outcome>) -> Self {
        match outcome {
            None => Self::NOT_YET,
            Some(Outcome::Transported) => Self { end: TactusEnd::Transported, ..Self::NOT_YET },
            Some(Outcome::Failed(reason)) => {
                let (failure, refusal) = match reason {
                    FailureReason::NoPlan(refusal) => (TactusFailure::NoPlan, refusal.into()),
                    FailureReason::NotConfident => (TactusFailure::NotConfident, TactusRefusal::None),
                    FailureReason::NothingFelt => (TactusFailure::NothingFelt, TactusRefusal::None),
                    FailureReason::GraspMissed => (TactusFailure::GraspMissed, TactusRefusal::None),
                    FailureReason::ObjectLost => (TactusFailure::ObjectLost, TactusRefusal::None),
                };
                Self { end: TactusEnd::Failed, failure, refusal, ..Self::NOT_YET }
            }
            Some(Outcome::Fault(reason)) => {
                let (fault, joint) = match reason {
                    FaultReason::HostSilent => (TactusFault::HostSilent, u8::MAX),
                    FaultReason::SensorInvalid => (TactusFault::SensorInvalid, u8::MAX),
                    FaultReason::JointLimit(joint) => (TactusFault::JointLimit, joint),
                    FaultReason::JointSpeed(joint) => (TactusFault::JointSpeed, joint),
                    FaultReason::Tracking(joint) => (TactusFault::Tracking, joint),
                    FaultReason::BadSetup => (TactusFault::BadSetup, u8::MAX),
                    FaultReason::SchemaMismatch => (TactusFault::SchemaMismatch, u8::MAX),
                    FaultReason::HostSlow => (TactusFault::HostSlow, u8::MAX),
                    FaultReason::NotInImage => (TactusFault::NotInImage, u8::MAX),
                };
                Self { end: TactusEnd::Fault, fault, joint, ..Self::NOT_YET }
            }
        }
    }
}
