//! Carry the object to its goal, set it down, let go and withdraw.
//!
//! If it slips on the way, the hand grips harder at once and the arm brings it back to where it stood; there the fingers
//! open, close anew with the harder grip, and the arm sets out again. Only a new hold shows whether it slips again: pads
//! that an object has slid over feel the same while it slides on.

use super::Tools;
use super::closing::Closing;
use super::grip::{Grip, SQUEEZE_TICKS};
use super::withdraw::RETURN_RATE;
use crate::executor::Motion;
use crate::slip::{Slip, Slipping};
use tactus_common::limits::FINGERS;
use tactus_common::message::EventKind;
use tactus_common::reading::{HandCommand, JointReadings};

/// Ticks over which the load is taken over and given back: 0.2 s.
const LOAD_TICKS: u32 = 100;
/// A finger that closes this much further than at the grasp holds nothing any more, radians.
const LOST_RAD: f32 = 0.2;
/// So sure it must be that an object slips out of the hardest grip before it is given up: changes of twice what is slip. The
/// harder a grip, the more the fingers give as they take the weight over.
const GIVE_UP_SURENESS: f32 = 0.8;
/// The fingers leave the object at this speed, rad/s.
const LEAVING_RAD_S: f32 = -0.5;
/// After this angle they are clear of it, radians.
const LEFT_RAD: f32 = 0.3;
const LEAVING_TICKS_MAX: u32 = 1_500;

#[derive(Clone, Copy, Debug)]
enum Step {
    /// Takes the load over and moves.
    Move { ticks: u32 },
    /// Brings back what slips: stops, then goes the way that it came.
    GoBack { begun: bool, then: Then },
    /// Gives the load back to the table.
    SetDown { left: u32, then: Then },
    /// Opens the fingers.
    Open { ticks: u32, then: Then },
    /// Closes them again.
    Close(Closing),
    /// Builds up the harder grip.
    Squeeze { left: u32 },
    /// Goes up.
    Rise,
    /// Stands.
    Over,
}

/// What setting the object down is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Then {
    /// It is where it is to be.
    Leave,
    /// To take it anew, harder.
    Retake,
    /// No grip holds it.
    GiveUp,
}

/// How far the carrying is.
pub enum CarryEnd {
    /// It goes on.
    NotYet,
    /// The object stands at its goal and the hand is clear of it.
    Done,
    /// The object is gone, or no grip holds it and the arm has brought it back to where it stood.
    Lost,
}

/// The carrying under way.
#[derive(Clone, Debug)]
pub struct Carry {
    step: Step,
    held_motor_rad: [f32; FINGERS],
    mass_kg: f32,
    load: f32,
    grip: Grip,
}

impl Carry {
    /// Begins with the object held by the first grip; the trajectory has just been loaded. `grip` is what it takes, as far
    /// as is known.
    pub fn new(readings: &JointReadings, mass_kg: f32, grip: Grip) -> Self {
        // A harder grip than the one that holds it is taken as any other: by letting go first.
        let step = if grip == Grip::default() {
            Step::Move { ticks: 0 }
        } else {
            Step::GoBack { begun: false, then: Then::Retake }
        };
        Self { step, held_motor_rad: held_motor_rad(readings), mass_kg, load: 0.0, grip }
    }

    /// The grip that it has come to.
    pub fn grip(&self) -> Grip {
        self.grip
    }

    /// The part of the object's mass that the arm carries now, kilograms.
    pub fn payload_kg(&self) -> f32 {
        self.load * self.mass_kg
    }

    /// Is it letting go?
    pub fn is_releasing(&self) -> bool {
        match self.step {
            Step::Move { .. } | Step::GoBack { .. } | Step::Close(_) | Step::Squeeze { .. } => false,
            Step::SetDown { then, .. } | Step::Open { then, .. } => then == Then::Leave,
            Step::Rise | Step::Over => true,
        }
    }

    /// One tick; `slip` belongs to this carrying.
    pub(super) fn step(&mut self, slip: &mut Slip, tools: &mut Tools) -> CarryEnd {
        self.step = match self.step {
            Step::Move { ticks } => {
                self.load = (ticks as f32 / LOAD_TICKS as f32).min(1.0);
                if self.is_lost(tools.readings) {
                    return lost(tools);
                }
                if tools.executor.motion() == Motion::AtGuard {
                    tools.executor.enter_guarded();
                }
                if tools.executor.at_end() {
                    Step::SetDown { left: LOAD_TICKS, then: Then::Leave }
                } else {
                    self.watch(slip, tools).unwrap_or(Step::Move { ticks: ticks + 1 })
                }
            }
            Step::GoBack { begun, then } => {
                if self.is_lost(tools.readings) {
                    return lost(tools);
                }
                if !begun {
                    tools.executor.pause();
                }
                if tools.executor.motion() != Motion::Holding {
                    Step::GoBack { begun, then }
                } else if !begun {
                    tools.executor.go_back(1.0);
                    Step::GoBack { begun: true, then }
                } else if then == Then::GiveUp {
                    return CarryEnd::Lost;
                } else {
                    Step::SetDown { left: (self.load * LOAD_TICKS as f32) as u32, then }
                }
            }
            Step::SetDown { left: 0, then } => Step::Open { ticks: 0, then },
            Step::SetDown { left, then } => {
                self.load = left as f32 / LOAD_TICKS as f32;
                Step::SetDown { left: left - 1, then }
            }
            Step::Open { ticks, then } => {
                self.load = 0.0;
                if !self.open(tools) && ticks < LEAVING_TICKS_MAX {
                    Step::Open { ticks: ticks + 1, then }
                } else if then == Then::Retake {
                    tools.onset.reset();
                    let [f1, f2, f3] = self.held_motor_rad;
                    Step::Close(Closing::new([true; FINGERS], f1.max(f2).max(f3) + LOST_RAD))
                } else {
                    tools.executor.go_back(RETURN_RATE);
                    Step::Rise
                }
            }
            Step::Close(mut closing) => {
                if !closing.step(tools, |_, _, _| ()) {
                    Step::Close(closing)
                } else if closing.holds() {
                    self.grip.command(tools.hand);
                    Step::Squeeze { left: SQUEEZE_TICKS }
                } else {
                    return lost(tools);
                }
            }
            Step::Squeeze { left: 0 } => {
                self.held_motor_rad = held_motor_rad(tools.readings);
                slip.reset();
                tools.executor.go_on();
                Step::Move { ticks: 0 }
            }
            Step::Squeeze { left } => Step::Squeeze { left: left - 1 },
            Step::Rise if tools.executor.motion() == Motion::Holding => Step::Over,
            Step::Rise => Step::Rise,
            Step::Over => return CarryEnd::Done,
        };
        CarryEnd::NotYet
    }

    /// What follows if the object slips: the next grip, and the way back. Tells of it. Only before the guarded part, in which
    /// the object meets the table.
    fn watch(&mut self, slip: &mut Slip, tools: &mut Tools) -> Option<Step> {
        if tools.executor.motion() != Motion::Travelling {
            return None;
        }
        let Slipping { finger, sureness } = slip.feel(tools.readings, tools.images)?;
        let then = if self.grip.raise(tools.readings) {
            Then::Retake
        } else if sureness >= GIVE_UP_SURENESS {
            Then::GiveUp
        } else {
            return None;
        };
        let grip_nm = self.grip.torque_nm(usize::from(finger));
        tools.out.event(EventKind::Slip { finger, sureness, grip_nm });
        self.grip.command(tools.hand);
        Some(Step::GoBack { begun: false, then })
    }

    /// Opens the fingers far enough to be clear of the object; `true` once they are.
    fn open(&self, tools: &mut Tools) -> bool {
        let mut clear = true;
        for (f, held_rad) in self.held_motor_rad.iter().enumerate() {
            let there = tools.readings.motor_q_rad[f] <= (held_rad - LEFT_RAD).max(0.0) + 0.01;
            tools.hand[f] = HandCommand::Velocity(if there { 0.0 } else { LEAVING_RAD_S });
            clear &= there;
        }
        clear
    }

    /// F3, or both of the others, went on closing: nothing is between them any more.
    fn is_lost(&self, readings: &JointReadings) -> bool {
        let closed = |f: usize| readings.motor_q_rad[f] - self.held_motor_rad[f] > LOST_RAD;
        closed(2) || (closed(0) && closed(1))
    }
}

/// Stops: the object is gone.
fn lost(tools: &mut Tools) -> CarryEnd {
    tools.executor.stop();
    CarryEnd::Lost
}

/// Where the motors of the fingers are, radians.
fn held_motor_rad(readings: &JointReadings) -> [f32; FINGERS] {
    let [f1, f2, f3, _] = readings.motor_q_rad;
    [f1, f2, f3]
}

#[cfg(test)]
mod tests;
