//! Questions to the planner and its answers.

use crate::geometry::TactusPose;
use crate::handle::{Plain, array};
use crate::result::TactusResult;
use crate::robot::{TACTUS_ARM_JOINTS, TACTUS_FINGERS};
use tactus_common::limits::KNOTS_MAX;
use tactus_common::message::{HandPlacement, PlanAnswer, PlanRequest, Preshape, Purpose, RefusalReason};
use tactus_common::trajectory::{Knot, Trajectory};

/// Most knots of one trajectory.
pub const TACTUS_KNOTS_MAX: usize = 48;
/// `guarded_from` of a trajectory without a guarded part.
pub const TACTUS_UNGUARDED: u8 = 255;

const _: () = assert!(TACTUS_KNOTS_MAX == KNOTS_MAX);

/// What a motion is for.
#[repr(u8)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TactusPurpose {
    /// Come down beside the object to touch it; the descent is guarded.
    #[default]
    Touch = 0,
    /// Come down over the object to grasp it; the descent is guarded.
    Grasp = 1,
    /// Lift the grasped object, carry it by the displacement, set it down.
    Transport = 2,
    /// Straight up and away; not guarded.
    Retreat = 3,
}

/// Why the planner has no trajectory.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusRefusal {
    /// It has one.
    None = 0,
    /// No joint angles within the limits put the hand there.
    NoInverseKinematics = 1,
    /// The goal is beyond the arm's reach.
    OutOfReach = 2,
    /// The robot is in collision where it stands.
    StartInCollision = 3,
    /// The robot would be in collision at the goal.
    GoalInCollision = 4,
    /// The search found no collision-free path.
    NoPath = 5,
    /// The path needs more knots than a trajectory holds.
    TooManyKnots = 6,
    /// The request holds a value that is not finite.
    NonFinite = 7,
}

impl From<RefusalReason> for TactusRefusal {
    fn from(reason: RefusalReason) -> Self {
        match reason {
            RefusalReason::NoInverseKinematics => Self::NoInverseKinematics,
            RefusalReason::OutOfReach => Self::OutOfReach,
            RefusalReason::StartInCollision => Self::StartInCollision,
            RefusalReason::GoalInCollision => Self::GoalInCollision,
            RefusalReason::NoPath => Self::NoPath,
            RefusalReason::TooManyKnots => Self::TooManyKnots,
            RefusalReason::NonFinite => Self::NonFinite,
        }
    }
}

/// A `TactusRefusal` as C wrote it; `None` stands for none.
fn refusal(code: u8) -> Result<Option<RefusalReason>, TactusResult> {
    Ok(Some(match code {
        0 => return Ok(None),
        1 => RefusalReason::NoInverseKinematics,
        2 => RefusalReason::OutOfReach,
        3 => RefusalReason::StartInCollision,
        4 => RefusalReason::GoalInCollision,
        5 => RefusalReason::NoPath,
        6 => RefusalReason::TooManyKnots,
        7 => RefusalReason::NonFinite,
        _ => return Err(TactusResult::BadValue),
    }))
}

/// Finger angles before closing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusPreshape {
    /// Inner links F1, F2, F3, radians.
    pub inner_rad: [f32; TACTUS_FINGERS],
    /// Spread, radians.
    pub spread_rad: f32,
}

impl From<Preshape> for TactusPreshape {
    fn from(p: Preshape) -> Self {
        Self { inner_rad: p.inner_rad, spread_rad: p.spread_rad }
    }
}

/// Where the hand goes, pointing straight down, relative to the believed object.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusPlacement {
    /// The hand's axis and yaw in the object's frame; at yaw 0 the hand's +x is the object's +x.
    pub hand_in_object: TactusPose,
    /// Height of the palm's face above the object's top, metres.
    pub palm_height_m: f32,
}

impl From<HandPlacement> for TactusPlacement {
    fn from(p: HandPlacement) -> Self {
        Self { hand_in_object: p.hand_in_object.into(), palm_height_m: p.palm_height_m }
    }
}

/// A question to the planner. Answer it with a `TactusPlanAnswer` in a later tick, within 10 s.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusPlanRequest {
    /// Arm joint angles to start from, radians.
    pub start_q_rad: [f32; TACTUS_ARM_JOINTS],
    /// Where the hand is to go (touch and grasp).
    pub placement: TactusPlacement,
    /// Finger angles on the way.
    pub preshape: TactusPreshape,
    /// Displacement of the object in the world, metres: now (transport), or next (grasp).
    pub displacement_m: [f32; 2],
    /// Believed pose of the object.
    pub belief: TactusPose,
    /// Upper triangle of its covariance: xx, xy, xphi, yy, yphi, phiphi (m^2, m rad, rad^2).
    pub covariance: [f32; 6],
    /// Number of this request; the answer carries it.
    pub request: u16,
    /// What the motion is for.
    pub purpose: TactusPurpose,
    /// Number of the candidate touch, 255 = none.
    pub touch: u8,
}

impl From<&PlanRequest> for TactusPlanRequest {
    fn from(r: &PlanRequest) -> Self {
        Self {
            start_q_rad: r.start_q_rad,
            placement: r.placement.into(),
            preshape: r.preshape.into(),
            displacement_m: r.displacement_m,
            belief: r.belief.into(),
            covariance: r.covariance,
            request: r.request,
            purpose: match r.purpose {
                Purpose::Touch => TactusPurpose::Touch,
                Purpose::Grasp => TactusPurpose::Grasp,
                Purpose::Transport => TactusPurpose::Transport,
                Purpose::Retreat => TactusPurpose::Retreat,
            },
            touch: r.touch,
        }
    }
}

/// State of the arm at one instant of a trajectory; quintic between two of them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusKnot {
    /// Time since the trajectory's start, seconds; the first at 0, the next each at least a tick later.
    pub t_s: f32,
    /// Joint angles J1..J7, radians.
    pub q_rad: [f32; TACTUS_ARM_JOINTS],
    /// Joint velocities, rad/s.
    pub qd_rad_s: [f32; TACTUS_ARM_JOINTS],
    /// Joint accelerations, rad/s^2.
    pub qdd_rad_s2: [f32; TACTUS_ARM_JOINTS],
}

// SAFETY: numbers only.
unsafe impl Plain for TactusKnot {}

/// The planner's answer. A trajectory that the arm cannot follow (limits, gaps, motion at its end) counts as refused.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusPlanAnswer {
    /// The knots, `knot_count` of them; copied before `tactus_controller_tick` returns. Not looked at in a refusal.
    pub knots: *const TactusKnot,
    /// Number of knots, at most `TACTUS_KNOTS_MAX`.
    pub knot_count: u16,
    /// Number of the request that this answers.
    pub request: u16,
    /// From this knot on a contact ends the motion; `TACTUS_UNGUARDED`: nowhere.
    pub guarded_from: u8,
    /// A `TactusRefusal`: why there is no trajectory, or `TACTUS_REFUSAL_NONE`.
    pub refusal: u8,
}

// SAFETY: numbers, and a pointer that is checked before use.
unsafe impl Plain for TactusPlanAnswer {}

impl TactusPlanAnswer {
    /// Writes the answer, taking effect at tick `now`, over `answer`: a trajectory is large, so it is filled where it
    /// stays. Never inlined, so that what it needs of the stack is free again when the controller ticks.
    ///
    /// # Safety
    /// The header's contract for `knots`.
    #[inline(never)]
    pub(crate) unsafe fn fill(&self, now: u32, answer: &mut PlanAnswer) -> Result<(), TactusResult> {
        (answer.effective, answer.request) = (now, self.request);
        if let Some(reason) = refusal(self.refusal)? {
            answer.result = Err(reason);
            return Ok(());
        }
        if usize::from(self.knot_count) > KNOTS_MAX {
            return Err(TactusResult::BadValue);
        }
        // SAFETY: the caller's promise.
        let knots = unsafe { array(self.knots, usize::from(self.knot_count)) }?;
        if answer.result.is_err() {
            answer.result = Ok(Trajectory::default());
        }
        if let Ok(trajectory) = &mut answer.result {
            trajectory.request = self.request;
            trajectory.guarded_from = self.guarded_from;
            trajectory.knots.clear();
            for k in knots {
                let knot = Knot { t_s: k.t_s, q_rad: k.q_rad, qd_rad_s: k.qd_rad_s, qdd_rad_s2: k.qdd_rad_s2 };
                trajectory.knots.push(knot).map_err(|_| TactusResult::BadValue)?;
            }
        }
        Ok(())
    }
}
