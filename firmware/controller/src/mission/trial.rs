//! One touch: come down guarded, close the fingers guarded, open, go back up.

use super::closing::Closing;
use super::descent::{Descent, DescentEnd};
use super::withdraw::Withdraw;
use super::{Knowledge, Tools, hand};
use crate::evidence::{ContactKind, Toucher};
use crate::touch::{CLOSED_RAD, TouchPlan};
use tactus_common::limits::{ARM_JOINTS, FINGERS};
use tactus_common::message::{EventKind, FaultReason};

/// Where a touch is.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// Moves there and comes down.
    Descend(Descent),
    /// Closes.
    Close(Closing),
    /// Opens and goes back up.
    Withdraw(Withdraw),
}

/// How far a touch has come.
pub enum TrialEnd {
    /// It goes on.
    NotYet,
    /// The hand does not do what it is told.
    Stuck(FaultReason),
    /// The hand is above again.
    Over {
        /// Arm angles during the closing, radians.
        arm_q_rad: [f32; ARM_JOINTS],
        /// Inner-link angle at onset per finger, radians.
        onset_inner_rad: [Option<f32>; FINGERS],
    },
}

/// A touch under way.
#[derive(Clone, Debug)]
pub struct Trial {
    plan: TouchPlan,
    step: Step,
    arm_q_rad: [f32; ARM_JOINTS],
    onset_inner_rad: [Option<f32>; FINGERS],
    /// Which fingers an obstacle may have stopped.
    on_obstacle: [bool; FINGERS],
}

impl Trial {
    /// A touch; its trajectory has just been loaded.
    pub fn new(plan: &TouchPlan) -> Self {
        Self {
            plan: *plan,
            step: Step::Descend(Descent::new(plan.preshape())),
            arm_q_rad: [0.0; ARM_JOINTS],
            onset_inner_rad: [None; FINGERS],
            on_obstacle: [false; FINGERS],
        }
    }

    /// What is being tried.
    pub fn plan(&self) -> &TouchPlan {
        &self.plan
    }

    /// One tick.
    pub(super) fn step(&mut self, know: &mut Knowledge, tools: &mut Tools) -> TrialEnd {
        let next = match &mut self.step {
            Step::Descend(descent) => match descent.step(know, tools) {
                DescentEnd::NotYet => None,
                DescentEnd::Stuck(reason) => return TrialEnd::Stuck(reason),
                DescentEnd::Landed { on_object } => {
                    if on_object {
                        let (world_from_hand, angles) = hand::measured(tools);
                        let arm_q_rad = tools.readings.arm_q_rad;
                        know.felt.landed(&self.plan, &world_from_hand, arm_q_rad, angles.inner_rad, tools.links);
                    }
                    Some(Step::Withdraw(Withdraw::at_once(tools)))
                }
                DescentEnd::Down => {
                    let (world_from_hand, angles) = hand::measured(tools);
                    // A full store drops the newest and counts it; the touch still counts with what it has.
                    let _ = know.store.add_free(&world_from_hand, &angles, [true; FINGERS]);
                    self.arm_q_rad = tools.readings.arm_q_rad;
                    know.felt.begin(&self.plan, &world_from_hand, self.arm_q_rad);
                    Some(Step::Close(Closing::new(self.plan.closes, CLOSED_RAD)))
                }
            },
            Step::Close(closing) => {
                let on_obstacle = &mut self.on_obstacle;
                let closed = closing.step(tools, |f, inner_rad, tools| {
                    let is_obstacle = !note_contact(f, inner_rad, know, tools);
                    if let Some(on_obstacle) = on_obstacle.get_mut(f) {
                        *on_obstacle |= is_obstacle;
                    }
                });
                know.felt.feel(tools.links);
                if self.on_obstacle.contains(&true) {
                    know.felt.discard();
                }
                if closed {
                    know.felt.end(tools.readings.inner_q_rad);
                    self.onset_inner_rad = closing.onset_inner_rad();
                    self.note_misses(know, tools);
                    self.leave_out_obstacles();
                }
                closed.then_some(Step::Withdraw(Withdraw::OPEN_FIRST))
            }
            Step::Withdraw(withdraw) => {
                if withdraw.step(&self.plan.preshape(), tools) {
                    return TrialEnd::Over { arm_q_rad: self.arm_q_rad, onset_inner_rad: self.onset_inner_rad };
                }
                None
            }
        };
        if let Some(next) = next {
            self.step = next;
        }
        TrialEnd::NotYet
    }

    /// A finger that an obstacle may have stopped is, for what is made of this touch, one that did not close.
    fn leave_out_obstacles(&mut self) {
        for ((closes, onset), on_obstacle) in
            self.plan.closes.iter_mut().zip(&mut self.onset_inner_rad).zip(self.on_obstacle)
        {
            if on_obstacle {
                (*closes, *onset) = (false, None);
            }
        }
    }

    /// Fingers that closed without feeling anything: their whole way is known to be free.
    fn note_misses(&self, know: &mut Knowledge, tools: &Tools) {
        let (world_from_hand, mut angles) = hand::measured(tools);
        for f in 0..FINGERS {
            if self.plan.closes[f] && self.onset_inner_rad[f].is_none() {
                let end_rad = angles.inner_rad[f];
                angles.inner_rad[f] = self.plan.preopen_rad[f];
                let _ = know.store.add_free_sweep(&world_from_hand, &angles, f, end_rad);
            }
        }
    }
}

/// Finger `f` begins to feel something: evidence, unless it may be an obstacle (`false`).
fn note_contact(f: usize, inner_rad: f32, know: &mut Knowledge, tools: &mut Tools) -> bool {
    let (world_from_hand, angles) = hand::measured(tools);
    tools.out.event(EventKind::Contact { finger: f as u8, inner_rad, descending: false });
    know.note_contact(&world_from_hand, &angles, Toucher::Finger(f), ContactKind::Closing)
}

#[cfg(test)]
mod tests;
