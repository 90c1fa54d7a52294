//! The way to the real arm and hand: Barrett's pucks instead of messages of ours.
//!
//! A driver beside [`crate::node`]: it makes [`JointReadings`] and [`TactileImage`]s of what pucks answer, and puck frames
//! of [`JointCommands`]. Who owns the bus calls, once a tick of 2 ms:
//!
//! 1. [`PuckDriver::begin`]: asks for positions and gauges.
//! 2. [`PuckDriver::receive`] for each frame that comes, until [`PuckDriver::is_complete`] or the time for answers is over.
//! 3. [`crate::controller::Controller::tick`] with [`PuckDriver::readings`] and [`PuckDriver::take_images`].
//! 4. [`PuckDriver::command`]: torques, what the hand is to do, a tactile pad.
//!
//! One bus of 1 Mbit/s carries the arm at 500 Hz and the hand at 250 Hz: positions at even ticks, fingertip gauges at
//! odd ones, one pad each fourth tick, so 31 images a second of each pad. A reading of the arm is of this tick or not
//! measured; one of the hand may be a tick old, and no older.
//!
//! [`startup`] comes first: it asks each puck what it is and what its torque unit is.
//!
//! Not measured: motor efforts (no reading of a known scale is known), so their validity bits stay unset.

mod hand;
pub mod startup;

use hand::HandOrders;
use tactus_common::can::CanFrame;
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PAD_CELLS, PADS};
use tactus_common::puck::tactile::{FullFrame, FullImage, Request, UNITS_PER_N_CM2};
use tactus_common::puck::units::{self, HAND_GEARS};
use tactus_common::puck::{
    Command, Counts, Feedback, Group, Message, Node, Position, Property, Report, Torques, property,
};
use tactus_common::reading::{JointCommands, JointReadings, TactileImage, Validity};
use tactus_common::robot::tables::{
    GEAR_SECONDARY, HAND_MOTOR_COUNTS, MOTOR_FROM_JOINT, SECONDARY_COUNTS, TIP_TORQUE_COUNTS_MAX,
    TIP_TORQUE_RESOLUTION_NM, TIP_TORQUE_ZERO_COUNTS,
};

/// Ticks that a reading of the hand may be old: it is asked for at every second tick.
const HAND_AGE_MAX: u32 = 1;
/// Ticks between two pads; they are asked for in turn.
const PAD_EVERY_TICKS: u32 = 4;

/// What differs from robot to robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Torque units per newton-metre at the motor, M1..M7 (property IPNM).
    pub arm_ipnm: [f32; ARM_JOINTS],
    /// Torque units per newton-metre at the motor, F1, F2, F3, spread.
    pub hand_ipnm: [f32; HAND_MOTORS],
    /// Raw value of each fingertip gauge without load.
    pub tip_zero_counts: [f32; FINGERS],
}

impl Default for Calibration {
    /// As robots leave the factory.
    fn default() -> Self {
        Self {
            arm_ipnm: units::ARM_IPNM,
            hand_ipnm: [units::HAND_IPNM; HAND_MOTORS],
            tip_zero_counts: [TIP_TORQUE_ZERO_COUNTS as f32; FINGERS],
        }
    }
}

/// Frames that were no use, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PuckStats {
    /// Not of this protocol, or not from a puck of this robot.
    pub foreign: u32,
    /// Of this protocol, but damaged, of a wrong length or with a value out of range.
    pub bad: u32,
    /// Answers to what this driver does not ask.
    pub unasked: u32,
    /// Ticks at which an answer was missing.
    pub incomplete_ticks: u32,
    /// Tactile images of which a frame was missing when the next one was asked for.
    pub torn_images: u32,
}

/// A value and the tick at which it was asked for.
#[derive(Clone, Copy, Debug)]
struct Sampled<T> {
    tick: u32,
    value: T,
}

/// The value, if it is at most `age_max` ticks old.
fn fresh<T: Copy>(sampled: Option<Sampled<T>>, now: u32, age_max: u32) -> Option<T> {
    sampled.filter(|s| now.wrapping_sub(s.tick) <= age_max).map(|s| s.value)
}

/// The driver: fixed size, no clock, no bus.
#[derive(Clone, Debug)]
pub struct PuckDriver {
    calibration: Calibration,
    tick: u32,
    begun: bool,
    /// Something came in at this tick.
    heard: bool,
    arm: [Option<Sampled<Counts>>; ARM_JOINTS],
    motors: [Option<Sampled<Counts>>; HAND_MOTORS],
    inner: [Option<Sampled<Counts>>; FINGERS],
    gauges: [Option<Sampled<u16>>; FINGERS],
    pads: [FullImage; PADS],
    pads_asked_at: [u32; PADS],
    pad_next: u8,
    images: [Option<TactileImage>; PADS],
    hand: HandOrders,
    stats: PuckStats,
}

impl PuckDriver {
    /// A driver that has asked for nothing yet.
    pub fn new(calibration: Calibration) -> Self {
        Self {
            calibration,
            tick: 0,
            begun: false,
            heard: false,
            arm: [None; ARM_JOINTS],
            motors: [None; HAND_MOTORS],
            inner: [None; FINGERS],
            gauges: [None; FINGERS],
            pads: [FullImage::default(); PADS],
            pads_asked_at: [0; PADS],
            pad_next: 0,
            images: [None; PADS],
            hand: HandOrders::default(),
            stats: PuckStats::default(),
        }
    }

    /// Counts of what was no use.
    pub fn stats(&self) -> PuckStats {
        self.stats
    }

    /// Does this tick ask the hand for positions (else for gauges)?
    fn asks_positions(&self) -> bool {
        self.tick.is_multiple_of(2)
    }

    /// A tick begins: asks.
    pub fn begin(&mut self, tick: u32, send: &mut dyn FnMut(CanFrame)) {
        if self.begun && !self.is_complete() {
            self.stats.incomplete_ticks = self.stats.incomplete_ticks.saturating_add(1);
        }
        self.tick = tick;
        self.begun = true;
        self.heard = false;
        send(Command::get(Group::ARM, property::motor::P).frame());
        let asked = if self.asks_positions() { property::motor::P } else { property::motor::SG };
        send(Command::get(Group::HAND, asked).frame());
    }

    /// Takes a frame from the bus; `true` if it was an answer to this driver.
    pub fn receive(&mut self, frame: &CanFrame) -> bool {
        let taken = match Message::parse(frame) {
            Ok(Message::Report(report)) => self.take(&report),
            Ok(Message::Command(_)) | Err(tactus_common::puck::ParseError::Foreign) => Err(Useless::Foreign),
            Err(_) => Err(Useless::Bad),
        };
        let count = match taken {
            Ok(()) => {
                self.heard = true;
                return true;
            }
            Err(Useless::Foreign) => &mut self.stats.foreign,
            Err(Useless::Bad) => &mut self.stats.bad,
            Err(Useless::Unasked) => &mut self.stats.unasked,
        };
        *count = count.saturating_add(1);
        false
    }

    fn take(&mut self, report: &Report) -> Result<(), Useless> {
        let tick = self.tick;
        if let Some(motor) = report.from().arm_motor() {
            let Feedback::Position(Position { primary, .. }) = report.feedback() else { return Err(Useless::Unasked) };
            return put(&mut self.arm, motor, tick, primary);
        }
        let motor = report.from().hand_motor().ok_or(Useless::Foreign)?;
        match report.feedback() {
            Feedback::Position(Position { primary, secondary }) => {
                put(&mut self.motors, motor, tick, primary)?;
                match secondary {
                    // The spread's second encoder, if it has one, says nothing.
                    Some(counts) if motor < FINGERS => put(&mut self.inner, motor, tick, counts),
                    Some(_) | None => Ok(()),
                }
            }
            Feedback::Secondary(counts) => put(&mut self.inner, motor, tick, counts),
            Feedback::Value(property::motor::SG, value) if motor < FINGERS => {
                let counts = u16::try_from(value.get()).map_err(|_| Useless::Bad)?;
                if u32::from(counts) > TIP_TORQUE_COUNTS_MAX {
                    return Err(Useless::Bad);
                }
                put(&mut self.gauges, motor, tick, counts)
            }
            // The spread answers the hand's group too; it has no gauge.
            Feedback::Value(property::motor::SG, _) => Ok(()),
            Feedback::TactileFull(frame) => {
                self.take_tactile(motor, &frame);
                Ok(())
            }
            Feedback::Value(..)
            | Feedback::TactileTop(_)
            | Feedback::Force(_)
            | Feedback::Torque(_)
            | Feedback::Acceleration(_) => Err(Useless::Unasked),
        }
    }

    /// Pads are numbered as the motors whose pucks carry them: the spread's carries the palm's.
    fn take_tactile(&mut self, pad: usize, frame: &FullFrame) {
        let (Some(parts), Some(stamp), Some(image)) =
            (self.pads.get_mut(pad), self.pads_asked_at.get(pad), self.images.get_mut(pad))
        else {
            return;
        };
        if let Some(cells) = parts.add(frame) {
            let mut pressure_n_cm2 = [0.0; PAD_CELLS];
            for (pressure, cell) in pressure_n_cm2.iter_mut().zip(cells) {
                *pressure = f32::from(cell) / UNITS_PER_N_CM2;
            }
            *image = Some(TactileImage { pad: pad as u8, stamp: *stamp, pressure_n_cm2 });
        }
    }

    /// Has everything come that was asked for at this tick? Tactile images are not waited for.
    pub fn is_complete(&self) -> bool {
        fn all<T>(values: &[Option<Sampled<T>>], now: u32) -> bool {
            values.iter().all(|value| value.as_ref().is_some_and(|v| v.tick == now))
        }
        let hand = if self.asks_positions() { all(&self.motors, self.tick) } else { all(&self.gauges, self.tick) };
        hand && all(&self.arm, self.tick)
    }

    /// The readings of this tick; `None` if nothing came at all.
    pub fn readings(&self) -> Option<JointReadings> {
        if !self.heard {
            return None;
        }
        let mut readings = JointReadings {
            tick: self.tick,
            arm_q_rad: [0.0; ARM_JOINTS],
            motor_q_rad: [0.0; HAND_MOTORS],
            inner_q_rad: [0.0; FINGERS],
            effort_nm: [0.0; HAND_MOTORS],
            tip_torque_nm: [0.0; FINGERS],
            valid: Validity::NONE,
        };
        self.read_arm(&mut readings);
        for (m, sampled) in self.motors.iter().enumerate() {
            if let Some(counts) = fresh(*sampled, self.tick, HAND_AGE_MAX) {
                readings.motor_q_rad[m] = units::hand_joint_rad(counts, HAND_MOTOR_COUNTS, HAND_GEARS[m]);
                readings.valid.0 |= 1 << (ARM_JOINTS + m);
            }
        }
        for (f, sampled) in self.inner.iter().enumerate() {
            if let Some(counts) = fresh(*sampled, self.tick, HAND_AGE_MAX) {
                readings.inner_q_rad[f] = units::hand_joint_rad(counts, SECONDARY_COUNTS, GEAR_SECONDARY);
                readings.valid.0 |= 1 << (ARM_JOINTS + HAND_MOTORS + f);
            }
        }
        for (f, sampled) in self.gauges.iter().enumerate() {
            if let Some(counts) = fresh(*sampled, self.tick, HAND_AGE_MAX) {
                let zero = self.calibration.tip_zero_counts[f];
                readings.tip_torque_nm[f] = (f32::from(counts) - zero) * TIP_TORQUE_RESOLUTION_NM;
                readings.valid.0 |= 1 << (ARM_JOINTS + 2 * HAND_MOTORS + FINGERS + f);
            }
        }
        Some(readings)
    }

    /// Arm joints; one is measured if every motor is that it hangs on.
    fn read_arm(&self, readings: &mut JointReadings) {
        let mut motor_rad = [0.0; ARM_JOINTS];
        let mut measured = (1 << ARM_JOINTS) - 1;
        for (m, (angle_rad, sampled)) in motor_rad.iter_mut().zip(self.arm).enumerate() {
            match fresh(sampled, self.tick, 0) {
                Some(counts) => *angle_rad = units::arm_motor_rad(counts),
                None => measured &= !joints_on(m),
            }
        }
        readings.arm_q_rad = units::joints_from_motors(&motor_rad);
        readings.valid.0 |= measured;
    }

    /// The tactile images that were completed since the last call.
    pub fn take_images(&mut self) -> [Option<TactileImage>; PADS] {
        core::mem::take(&mut self.images)
    }

    /// Commands of this tick: torques always, for the hand what has changed, a pad when it is due.
    pub fn command(&mut self, commands: &JointCommands, send: &mut dyn FnMut(CanFrame)) {
        let motor_nm = units::motor_torques(&commands.arm_tau_nm);
        let mut unit = [0; ARM_JOINTS];
        for (m, unit) in unit.iter_mut().enumerate() {
            *unit = units::torque_units(motor_nm[m], self.calibration.arm_ipnm[m]);
        }
        let [a, b, c, d, e, f, g] = unit;
        send(Command::torques(Group::LOWER_ARM, Torques::clamped([a, b, c, d])).frame());
        send(Command::torques(Group::WRIST, Torques::clamped([e, f, g, 0])).frame());
        let sent = self.hand.update(&commands.hand, &self.calibration.hand_ipnm, send);
        // Gauges' ticks have room for a pad; what the hand is to do comes first.
        if self.tick % PAD_EVERY_TICKS == 1 && sent == 0 {
            self.ask_pad(send);
        }
    }

    /// Asks the next pad for an image.
    fn ask_pad(&mut self, send: &mut dyn FnMut(CanFrame)) {
        let pad = usize::from(self.pad_next);
        self.pad_next = (self.pad_next + 1) % PADS as u8;
        let (Some(node), Some(parts), Some(asked_at)) =
            (Node::HAND.get(pad), self.pads.get_mut(pad), self.pads_asked_at.get_mut(pad))
        else {
            return;
        };
        if parts.restart() {
            self.stats.torn_images = self.stats.torn_images.saturating_add(1);
        }
        *asked_at = self.tick;
        send(set_tactile(*node, Request::Full));
    }
}

/// The joints that hang on motor `m`, a bit each.
fn joints_on(m: usize) -> u32 {
    MOTOR_FROM_JOINT[m].iter().enumerate().map(|(j, turns)| u32::from(*turns != 0.0) << j).sum()
}

/// Why a frame is not taken.
enum Useless {
    Foreign,
    Bad,
    Unasked,
}

/// Puts a value at its place.
fn put<T>(values: &mut [Option<Sampled<T>>], index: usize, tick: u32, value: T) -> Result<(), Useless> {
    *values.get_mut(index).ok_or(Useless::Unasked)? = Some(Sampled { tick, value });
    Ok(())
}

/// Selects the format of a pad and asks for an image; takes no notice of what the pad was told before.
fn set_tactile(node: Node, request: Request) -> CanFrame {
    const TACT: Property = property::motor::TACT;
    Command::set(node, TACT, request as i16).frame()
}

#[cfg(test)]
mod tests;
