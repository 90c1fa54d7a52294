//! Carry the object to its goal, set it down, let go and withdraw.

use super::Tools;
use super::withdraw::RETURN_RATE;
use crate::executor::Motion;
use tactus_common::limits::FINGERS;
use tactus_common::reading::{HandCommand, JointReadings};

/// Ticks over which the load is taken over and given back: 0.2 s.
const LOAD_TICKS: u32 = 100;
/// A finger that closes this much further than at the grasp holds nothing any more, radians.
const LOST_RAD: f32 = 0.2;
/// The fingers leave the object at this speed, rad/s.
const LEAVING_RAD_S: f32 = -0.5;
/// After this angle they are clear of it, radians.
const LEFT_RAD: f32 = 0.3;
const LEAVING_TICKS_MAX: u32 = 1_500;

#[derive(Clone, Copy, Debug)]
enum Step {
    /// Takes the load over and moves.
    Move { ticks: u32 },
    /// Gives the load back to the table.
    SetDown { left: u32 },
    /// Opens the fingers.
    Open { ticks: u32 },
    /// Goes up.
    Rise,
    /// Stands.
    Over,
}

/// How far the carrying is.
pub enum CarryEnd {
    /// It goes on.
    NotYet,
    /// The object stands at its goal and the hand is clear of it.
    Done,
    /// The object is gone.
    Lost,
}

/// The carrying under way.
#[derive(Clone, Debug)]
pub struct Carry {
    step: Step,
    held_motor_rad: [f32; FINGERS],
    mass_kg: f32,
    load: f32,
}

impl Carry {
    /// Begins with the object held; the trajectory has just been loaded.
    pub fn new(readings: &JointReadings, mass_kg: f32) -> Self {
        let [f1, f2, f3, _] = readings.motor_q_rad;
        Self { step: Step::Move { ticks: 0 }, held_motor_rad: [f1, f2, f3], mass_kg, load: 0.0 }
    }

    /// The part of the object's mass that the arm carries now, kilograms.
    pub fn payload_kg(&self) -> f32 {
        self.load * self.mass_kg
    }

    /// Is it letting go?
    pub fn is_releasing(&self) -> bool {
        !matches!(self.step, Step::Move { .. })
    }

    /// One tick.
    pub(super) fn step(&mut self, tools: &mut Tools) -> CarryEnd {
        self.step = match self.step {
            Step::Move { ticks } => {
                self.load = (ticks as f32 / LOAD_TICKS as f32).min(1.0);
                if self.is_lost(tools.readings) {
                    tools.executor.stop();
                    return CarryEnd::Lost;
                }
                if tools.executor.motion() == Motion::AtGuard {
                    tools.executor.enter_guarded();
                }
                if tools.executor.at_end() {
                    Step::SetDown { left: LOAD_TICKS }
                } else {
                    Step::Move { ticks: ticks + 1 }
                }
            }
            Step::SetDown { left: 0 } => Step::Open { ticks: 0 },
            Step::SetDown { left } => {
                self.load = left as f32 / LOAD_TICKS as f32;
                Step::SetDown { left: left - 1 }
            }
            Step::Open { ticks } => {
                self.load = 0.0;
                let mut clear = true;
                for f in 0..FINGERS {
                    let target_rad = (self.held_motor_rad[f] - LEFT_RAD).max(0.0);
                    let there = tools.readings.motor_q_rad[f] <= target_rad + 0.01;
                    tools.hand[f] = HandCommand::Velocity(if there { 0.0 } else { LEAVING_RAD_S });
                    clear &= there;
                }
                if clear || ticks >= LEAVING_TICKS_MAX {
                    tools.executor.go_back(RETURN_RATE);
                    Step::Rise
                } else {
                    Step::Open { ticks: ticks + 1 }
                }
            }
            Step::Rise if tools.executor.motion() == Motion::Holding => Step::Over,
            Step::Rise => Step::Rise,
            Step::Over => return CarryEnd::Done,
        };
        CarryEnd::NotYet
    }

    /// F3, or both of the others, went on closing: nothing is between them any more.
    fn is_lost(&self, readings: &JointReadings) -> bool {
        let closed = |f: usize| readings.motor_q_rad[f] - self.held_motor_rad[f] > LOST_RAD;
        closed(2) || (closed(0) && closed(1))
    }
}

#[cfg(test)]
mod tests;
