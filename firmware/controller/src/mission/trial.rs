//! One touch: move above the place, come down guarded, close the fingers guarded, open, go back up.

use super::{Knowledge, Tools, hand};
use crate::evidence::{ContactKind, Toucher};
use crate::executor::Motion;
use crate::touch::TouchPlan;
use tactus_common::limits::{ARM_JOINTS, FINGERS};
use tactus_common::message::EventKind;
use tactus_common::reading::HandCommand;

/// Closing speed of a finger, rad/s at the inner link: 0.04 m/s at the tip, so 0.3 mm in the four ticks between
/// contact and standstill.
pub const CLOSING_RAD_S: f32 = 0.35;
/// A finger that comes this far without feeling anything has missed, radians.
const CLOSED_RAD: f32 = 1.75;
/// Ticks for vibration to die before a guarded motion: 60 ms.
const SETTLE_TICKS: u32 = 30;
/// Most ticks of a closing: 12 s.
const CLOSING_TICKS_MAX: u32 = 6_000;
/// Most ticks to open the fingers again: 3 s.
const OPENING_TICKS_MAX: u32 = 1_500;
/// The way up is this much faster than the guarded way down.
pub const RETURN_RATE: f32 = 3.0;

/// Where a touch is.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// On the way to the place above; fingers to their preshape.
    Approach,
    /// Stands above; lets vibration die.
    SettleAbove { left: u32 },
    /// Comes down.
    Descend,
    /// Felt something on the way down; comes to a stop.
    Landing,
    /// Stands below; lets vibration die.
    SettleBelow { left: u32 },
    /// Closes.
    Close { ticks: u32 },
    /// Opens.
    Open { ticks: u32 },
    /// Goes back up.
    Rise,
}

/// How far a touch has come.
pub enum TrialEnd {
    /// It goes on.
    NotYet,
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
    stopped: [bool; FINGERS],
}

impl Trial {
    /// A touch; its trajectory has just been loaded.
    pub fn new(plan: &TouchPlan) -> Self {
        Self {
            plan: *plan,
            step: Step::Approach,
            arm_q_rad: [0.0; ARM_JOINTS],
            onset_inner_rad: [None; FINGERS],
            stopped: [false; FINGERS],
        }
    }

    /// What is being tried.
    pub fn plan(&self) -> &TouchPlan {
        &self.plan
    }

    /// One tick.
    pub(super) fn step(&mut self, know: &mut Knowledge, tools: &mut Tools) -> TrialEnd {
        self.step = match self.step {
            Step::Approach => {
                let shaped = hand::preshape(&self.plan.preshape(), tools);
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
                let (world_from_hand, angles) = hand::measured(tools.readings);
                // Full stores drop the newest and count it; the touch still counts with what it has.
                let _ = know.store.add_free(&world_from_hand, &angles, [true; FINGERS]);
                self.arm_q_rad = tools.readings.arm_q_rad;
                tools.onset.reset();
                Step::Close { ticks: 0 }
            }
            Step::SettleBelow { left } => Step::SettleBelow { left: left - 1 },
            Step::Close { ticks } => {
                if self.close(know, tools) || ticks >= CLOSING_TICKS_MAX {
                    self.note_misses(know, tools);
                    Step::Open { ticks: 0 }
                } else {
                    Step::Close { ticks: ticks + 1 }
                }
            }
            Step::Open { ticks } => {
                if hand::preshape(&self.plan.preshape(), tools) || ticks >= OPENING_TICKS_MAX {
                    tools.executor.go_back(RETURN_RATE);
                    Step::Rise
                } else {
                    Step::Open { ticks: ticks + 1 }
                }
            }
            Step::Rise if tools.executor.motion() == Motion::Holding => {
                return TrialEnd::Over { arm_q_rad: self.arm_q_rad, onset_inner_rad: self.onset_inner_rad };
            }
            Step::Rise => Step::Rise,
        };
        TrialEnd::NotYet
    }

    /// Closes the fingers of the plan; each stops where it feels something. `true` when all have stopped.
    fn close(&mut self, know: &mut Knowledge, tools: &mut Tools) -> bool {
        let mut all = true;
        for f in 0..FINGERS {
            let inner_rad = tools.readings.inner_q_rad[f];
            if tools.felt.fingers[f] && self.onset_inner_rad[f].is_none() {
                self.onset_inner_rad[f] = Some(inner_rad);
                self.stopped[f] = true;
                record_contact(f, ContactKind::Closing, know, tools);
                tools.out.event(EventKind::Contact { finger: f as u8, inner_rad, descending: false });
            }
            if !self.plan.closes[f] || inner_rad >= CLOSED_RAD {
                self.stopped[f] = true;
            }
            tools.hand[f] = HandCommand::Velocity(if self.stopped[f] { 0.0 } else { CLOSING_RAD_S });
            all &= self.stopped[f];
        }
        all
    }

    /// Fingers that closed without feeling anything: their whole way is known to be free.
    fn note_misses(&mut self, know: &mut Knowledge, tools: &Tools) {
        let (world_from_hand, mut angles) = hand::measured(tools.readings);
        for f in 0..FINGERS {
            if self.plan.closes[f] && self.onset_inner_rad[f].is_none() {
                let end_rad = angles.inner_rad[f];
                angles.inner_rad[f] = self.plan.preopen_rad[f];
                let _ = know.store.add_free_sweep(&world_from_hand, &angles, f, end_rad);
            }
        }
    }
}

/// Notes that finger `f` feels something now.
pub(super) fn record_contact(f: usize, kind: ContactKind, know: &mut Knowledge, tools: &Tools) {
    let (world_from_hand, angles) = hand::measured(tools.readings);
    let _ = know.store.add_contact(&world_from_hand, &angles, Toucher::Finger(f), kind);
}

/// Something was felt on the way down: what felt it touches, the rest is free.
pub(super) fn land(know: &mut Knowledge, tools: &mut Tools) {
    let (world_from_hand, angles) = hand::measured(tools.readings);
    let free = tools.felt.fingers.map(|felt| !felt);
    let _ = know.store.add_free(&world_from_hand, &angles, free);
    for f in 0..FINGERS {
        if tools.felt.fingers[f] {
            record_contact(f, ContactKind::Landing, know, tools);
            let inner_rad = angles.inner_rad[f];
            tools.out.event(EventKind::Contact { finger: f as u8, inner_rad, descending: true });
        }
    }
    if tools.felt.palm {
        let _ = know.store.add_contact(&world_from_hand, &angles, Toucher::Palm, ContactKind::Landing);
        tools.out.event(EventKind::Contact { finger: FINGERS as u8, inner_rad: 0.0, descending: true });
    }
}

#[cfg(test)]
mod tests;
