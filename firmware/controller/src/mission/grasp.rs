//! The grasp: come down over the object, close all fingers gently, then squeeze.

use super::closing::Closing;
use super::descent::{Descent, DescentEnd};
use super::grip::{Grip, SQUEEZE_TICKS};
use super::withdraw::Withdraw;
use super::{Knowledge, Tools};
use crate::touch::layout::{Footprint, palm_height_m};
use core::f32::consts::{FRAC_PI_2, PI};
use tactus_common::limits::FINGERS;
use tactus_common::message::{FaultReason, HandPlacement, Preshape};
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;

/// Half the length of an object that the fingers still go across, with 45 mm to spare on either side, metres.
const HALF_LENGTH_MAX_M: f32 = 0.09;
/// Inner-link angle with which the hand comes down, radians.
const OPEN_RAD: f32 = 0.25;
/// Inner-link angle at which a closing finger is well on its way and nothing of usual width is reached, radians.
pub(super) const HALF_CLOSED_RAD: f32 = 0.6;
/// A finger that comes this far has missed the object, radians.
const CLOSED_RAD: f32 = 1.6;

/// Where the hand goes and how its fingers stand.
#[derive(Clone, Copy, Debug)]
pub struct GraspPlan {
    /// Placement relative to the object.
    pub placement: HandPlacement,
    /// Finger angles on the way down.
    pub preshape: Preshape,
}

/// The ways to grasp, best first: across the narrowest sides, F3 on either, and then across the ends, if they are near enough to
/// each other. The hand's x axis (from F3 to F1/F2) runs across. `None` beyond the last.
pub fn grasp_plan(variant: u8, shape: &ObjectShape) -> Option<GraspPlan> {
    let footprint = Footprint::of(shape);
    let across_ends = footprint.half_m[0] <= HALF_LENGTH_MAX_M;
    let yaw_rad = match variant {
        0 => FRAC_PI_2,
        1 => -FRAC_PI_2,
        2 if across_ends => 0.0,
        3 if across_ends => PI,
        _ => return None,
    };
    let hand_in_object = footprint.place(PlanarPose::new(0.0, 0.0, yaw_rad));
    Some(GraspPlan {
        placement: HandPlacement { hand_in_object, palm_height_m: palm_height_m(shape) },
        preshape: Preshape { inner_rad: [OPEN_RAD; FINGERS], spread_rad: 0.0 },
    })
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Descend(Descent),
    Close(Closing),
    Squeeze { left: u32 },
    Withdraw(Withdraw),
}

/// How a grasp ended.
pub enum GraspEnd {
    /// It goes on.
    NotYet,
    /// The hand does not do what it is told.
    Stuck(FaultReason),
    /// The object is held with these finger angles.
    Held(Preshape),
    /// Something was felt on the way down.
    Landed,
    /// The fingers closed without holding it.
    Missed,
}

/// A grasp under way.
#[derive(Clone, Debug)]
pub struct Grasp {
    plan: GraspPlan,
    step: Step,
    missed: bool,
}

impl Grasp {
    /// A grasp; its trajectory has just been loaded.
    pub fn new(plan: GraspPlan) -> Self {
        Self { plan, step: Step::Descend(Descent::new(plan.preshape)), missed: false }
    }

    /// One tick.
    pub(super) fn step(&mut self, know: &mut Knowledge, tools: &mut Tools) -> GraspEnd {
        let next = match &mut self.step {
            Step::Descend(descent) => match descent.step(know, tools) {
                DescentEnd::NotYet => None,
                DescentEnd::Stuck(reason) => return GraspEnd::Stuck(reason),
                DescentEnd::Landed { .. } => Some(Step::Withdraw(Withdraw::at_once(tools))),
                DescentEnd::Down => Some(Step::Close(Closing::new([true; FINGERS], CLOSED_RAD))),
            },
            Step::Close(closing) => {
                let closed = closing.step(tools, |_, _, _| ());
                if !closed {
                    None
                } else if closing.holds() {
                    Grip::default().command(tools.hand);
                    Some(Step::Squeeze { left: SQUEEZE_TICKS })
                } else {
                    self.missed = true;
                    Some(Step::Withdraw(Withdraw::OPEN_FIRST))
                }
            }
            Step::Squeeze { left: 0 } => {
                let r = tools.readings;
                return GraspEnd::Held(Preshape { inner_rad: r.inner_q_rad, spread_rad: r.motor_q_rad[FINGERS] });
            }
            Step::Squeeze { left } => {
                *left -= 1;
                None
            }
            Step::Withdraw(withdraw) => {
                if withdraw.step(&self.plan.preshape, tools) {
                    return if self.missed { GraspEnd::Missed } else { GraspEnd::Landed };
                }
                None
            }
        };
        if let Some(next) = next {
            self.step = next;
        }
        GraspEnd::NotYet
    }
}

#[cfg(test)]
mod tests;
