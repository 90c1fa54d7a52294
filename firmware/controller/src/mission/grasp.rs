//! The grasp: come down over the object, close all fingers gently, then squeeze.

use super::trial::{RETURN_RATE, land};
use super::{Knowledge, Tools, grip, hand};
use crate::executor::Motion;
use core::f32::consts::FRAC_PI_2;
use tactus_common::limits::FINGERS;
use tactus_common::message::{HandPlacement, Preshape};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::HandCommand;

/// Ways to grasp: across the depth, F3 on either side.
pub const VARIANTS: u8 = 2;
/// Palm face above the object's top, metres: 30 mm keep the inner links off the edges, the rest is margin.
const PALM_ABOVE_TOP_M: f32 = 0.046;
/// Inner-link angle with which the hand comes down, radians.
const OPEN_RAD: f32 = 0.25;
/// Closing speed, rad/s.
const CLOSING_RAD_S: f32 = 0.35;
/// A finger that comes this far has missed the object, radians.
const CLOSED_RAD: f32 = 1.6;
const SETTLE_TICKS: u32 = 30;
const CLOSING_TICKS_MAX: u32 = 3_000;
/// Ticks to build up the grip: 0.4 s.
const SQUEEZE_TICKS: u32 = 200;

/// Where the hand goes and how its fingers stand.
#[derive(Clone, Copy, Debug)]
pub struct GraspPlan {
    /// Placement relative to the object.
    pub placement: HandPlacement,
    /// Finger angles on the way down.
    pub preshape: Preshape,
}

/// The ways to grasp, best first. The hand's x axis (from F3 to F1/F2) lies along the object's depth, its y.
pub fn grasp_plan(variant: u8) -> GraspPlan {
    let yaw_rad = if variant == 0 { FRAC_PI_2 } else { -FRAC_PI_2 };
    GraspPlan {
        placement: HandPlacement { hand_in_object: PlanarPose::new(0.0, 0.0, yaw_rad), palm_height_m: PALM_ABOVE_TOP_M },
        preshape: Preshape { inner_rad: [OPEN_RAD; FINGERS], spread_rad: 0.0 },
    }
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Approach,
    SettleAbove { left: u32 },
    Descend,
    Landing,
    SettleBelow { left: u32 },
    Close { ticks: u32 },
    Squeeze { left: u32 },
    Open { ticks: u32 },
    Rise,
}

/// How a grasp ended.
pub enum GraspEnd {
    /// It goes on.
    NotYet,
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
    stopped: [bool; FINGERS],
    felt: [bool; FINGERS],
    missed: bool,
}

impl Grasp {
    /// A grasp; its trajectory has just been loaded.
    pub fn new(plan: GraspPlan) -> Self {
        Self { plan, step: Step::Approach, stopped: [false; FINGERS], felt: [false; FINGERS], missed: false }
    }

    /// One tick.
    pub(super) fn step(&mut self, know: &mut Knowledge, tools: &mut Tools) -> GraspEnd {
        self.step = match self.step {
            Step::Approach => {
                let shaped = hand::preshape(&self.plan.preshape, tools);
                match tools.executor.motion() {
                    Motion::AtGuard if shaped => Step::SettleAbove { left: SETTLE_TICKS },
                    _ => Step::Approach,
                }
            }
            Step::SettleAbove { left: 0 } => {
                tools.onset.reset();
                tools.executor.enter_guarded();
                Step::Descend
            }
            Step::SettleAbove { left } => Step::SettleAbove { left: left - 1 },
            Step::Descend if tools.felt.any() => {
                land(know, tools);
                tools.executor.stop();
                Step::Landing
            }
            Step::Descend if tools.executor.at_end() => Step::SettleBelow { left: SETTLE_TICKS },
            Step::Descend => Step::Descend,
            Step::Landing if tools.executor.motion() == Motion::Holding => {
                tools.executor.go_back(RETURN_RATE);
                Step::Rise
            }
            Step::Landing => Step::Landing,
            Step::SettleBelow { left: 0 } => {
                tools.onset.reset();
                Step::Close { ticks: 0 }
            }
            Step::SettleBelow { left } => Step::SettleBelow { left: left - 1 },
            Step::Close { ticks } => {
                if !self.close(tools) && ticks < CLOSING_TICKS_MAX {
                    Step::Close { ticks: ticks + 1 }
                } else if self.felt[2] && (self.felt[0] || self.felt[1]) {
                    grip::squeeze(tools.hand);
                    Step::Squeeze { left: SQUEEZE_TICKS }
                } else {
                    self.missed = true;
                    Step::Open { ticks: 0 }
                }
            }
            Step::Squeeze { left: 0 } => {
                let r = tools.readings;
                let inner_rad = r.inner_q_rad;
                return GraspEnd::Held(Preshape { inner_rad, spread_rad: r.motor_q_rad[FINGERS] });
            }
            Step::Squeeze { left } => Step::Squeeze { left: left - 1 },
            Step::Open { ticks } => {
                if hand::preshape(&self.plan.preshape, tools) || ticks >= CLOSING_TICKS_MAX {
                    tools.executor.go_back(RETURN_RATE);
                    Step::Rise
                } else {
                    Step::Open { ticks: ticks + 1 }
                }
            }
            Step::Rise if tools.executor.motion() == Motion::Holding => {
                return if self.missed { GraspEnd::Missed } else { GraspEnd::Landed };
            }
            Step::Rise => Step::Rise,
        };
        GraspEnd::NotYet
    }

    /// Closes all fingers; each stops where it feels something. `true` when all have stopped.
    fn close(&mut self, tools: &mut Tools) -> bool {
        for f in 0..FINGERS {
            self.felt[f] |= tools.felt.fingers[f];
            self.stopped[f] |= self.felt[f] || tools.readings.inner_q_rad[f] >= CLOSED_RAD;
            tools.hand[f] = HandCommand::Velocity(if self.stopped[f] { 0.0 } else { CLOSING_RAD_S });
        }
        self.stopped == [true; FINGERS]
    }
}

#[cfg(test)]
mod tests;
