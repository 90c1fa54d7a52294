//! What happened in a tick.

use crate::geometry::TactusPose;
use crate::plan::TactusRefusal;
use crate::setup::{TactusOutcome, TactusPhase};
use tactus_common::message::{Event, EventKind};

/// What happened.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusEventKind {
    /// A phase began: `phase`.
    Phase = 0,
    /// A touch began: `candidate`, `information_nats`.
    Touch = 1,
    /// A finger felt something: `finger`, `inner_rad`, `yes` if it was while the hand came down.
    Contact = 2,
    /// The belief was corrected: `belief`, `evaluations`, `modes`, `yes` if the next step is the grasp.
    Updated = 3,
    /// The simulation agreed (`yes`) with what was felt, or not.
    Confirmed = 4,
    /// The planner refused a motion: `refusal`.
    Refused = 5,
    /// The mission ended: `outcome`.
    Finished = 6,
    /// The object slips in the hand: `finger`, `sureness`, `grip_nm`.
    Slip = 7,
}

/// Something happened. Only the fields that its kind names say anything.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusEvent {
    /// When.
    pub tick: u32,
    /// What, and which of the fields below tell more.
    pub kind: TactusEventKind,
    /// The phase that began.
    pub phase: TactusPhase,
    /// Why the planner refused.
    pub refusal: TactusRefusal,
    /// How the mission ended.
    pub outcome: TactusOutcome,
    /// Yes or no, as the kind says.
    pub yes: bool,
    /// Number of the touch among the candidates.
    pub candidate: u8,
    /// 0, 1, 2 = F1, F2, F3; 3 = palm.
    pub finger: u8,
    /// Distinct poses that explain the evidence.
    pub modes: u8,
    /// Error evaluations of the update.
    pub evaluations: u16,
    /// Information that the touch is expected to give, nats.
    pub information_nats: f32,
    /// Inner-link angle at the moment of contact, radians.
    pub inner_rad: f32,
    /// How sure it is that the object slips, 0.5 to 1.
    pub sureness: f32,
    /// What the finger is to push with from now on, newton-metres at its inner joint.
    pub grip_nm: f32,
    /// Believed pose.
    pub belief: TactusPose,
}

impl TactusEvent {
    pub(crate) const NONE: Self = Self {
        tick: 0,
        kind: TactusEventKind::Phase,
        phase: TactusPhase::Initialise,
        refusal: TactusRefusal::None,
        outcome: TactusOutcome::NOT_YET,
        yes: false,
        candidate: 0,
        finger: 0,
        modes: 0,
        evaluations: 0,
        information_nats: 0.0,
        inner_rad: 0.0,
        sureness: 0.0,
        grip_nm: 0.0,
        belief: TactusPose { x_m: 0.0, y_m: 0.0, phi_rad: 0.0 },
    };
}

impl From<&Event> for TactusEvent {
    fn from(event: &Event) -> Self {
        let told = Self { tick: event.tick, ..Self::NONE };
        match event.kind {
            EventKind::Phase(phase) => Self { kind: TactusEventKind::Phase, phase: phase.into(), ..told },
            EventKind::Touch { candidate, information_nats } => {
                Self { kind: TactusEventKind::Touch, candidate, information_nats, ..told }
            }
            EventKind::Contact { finger, inner_rad, descending } => {
                Self { kind: TactusEventKind::Contact, finger, inner_rad, yes: descending, ..told }
            }
            // The covariance is in the belief, which can be asked for.
            EventKind::Updated { belief, covariance: _, evaluations, modes, confident } => Self {
                kind: TactusEventKind::Updated,
                belief: belief.into(),
                evaluations,
                modes,
                yes: confident,
                ..told
            },
            EventKind::Confirmed(agreed) => Self { kind: TactusEventKind::Confirmed, yes: agreed, ..told },
            EventKind::Refused(reason) => Self { kind: TactusEventKind::Refused, refusal: reason.into(), ..told },
            EventKind::Finished(outcome) => {
                Self { kind: TactusEventKind::Finished, outcome: Some(outcome).into(), ..told }
            }
            EventKind::Slip { finger, sureness, grip_nm } => {
                Self { kind: TactusEventKind::Slip, finger, sureness, grip_nm, ..told }
            }
        }
    }
}
