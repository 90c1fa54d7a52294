//! One tick of sensor readings and one tick of commands, in SI units at the joints.
//!
//! These are what the mission knows; how a bus packs them ([`crate::message`] here, Barrett's pucks elsewhere)
//! is a driver's matter.

use crate::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PAD_CELLS};

/// Readings of one tick. A value whose bit in [`Validity`] is unset was not measured and must not be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointReadings {
    /// The tick at which these were sampled.
    pub tick: u32,
    /// Arm joint angles, J1..J7, radians.
    pub arm_q_rad: [f32; ARM_JOINTS],
    /// Hand motor positions as joint angles, F1 F2 F3 spread, radians: motor angle over the gear ratio to the
    /// inner link (125) or the spread (17.5). Equals the inner link's angle while nothing bends or breaks away.
    pub motor_q_rad: [f32; HAND_MOTORS],
    /// Inner-link angles by the secondary encoders, F1 F2 F3, radians.
    pub inner_q_rad: [f32; FINGERS],
    /// Hand motor efforts as torques at the joint, F1 F2 F3 spread, newton-metres, positive = closing.
    pub effort_nm: [f32; HAND_MOTORS],
    /// Fingertip torques about the distal joint (strain gauges), F1 F2 F3, newton-metres. Positive = the world
    /// pushes the fingertip open, as a contact on the pad does. Weight and inertia of the tip are in the value.
    pub tip_torque_nm: [f32; FINGERS],
    /// Which of the above were measured.
    pub valid: Validity,
}

impl JointReadings {
    /// `true` if every value is a finite number.
    pub fn is_finite(&self) -> bool {
        let joints = self.arm_q_rad.iter().chain(&self.motor_q_rad).chain(&self.inner_q_rad);
        joints.chain(&self.effort_nm).chain(&self.tip_torque_nm).all(|v| v.is_finite())
    }
}

/// Which readings of a tick were measured: bits 0-6 arm, 7-10 motors, 11-13 inner links, 14-17 efforts, 18-20 tips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Validity(pub u32);

impl Validity {
    /// Every reading measured.
    pub const ALL: Self = Self((1 << 21) - 1);
    /// No reading measured.
    pub const NONE: Self = Self(0);

    /// All seven arm angles measured?
    pub fn arm(self) -> bool {
        self.0 & 0x7f == 0x7f
    }

    /// All hand readings that are needed (motors, inner links, tips) measured? Efforts are not: the real hand's motor
    /// controllers do not tell them.
    pub fn hand(self) -> bool {
        const NEEDED: u32 = 0x3f80 | 0x1c_0000;
        self.0 & NEEDED == NEEDED
    }
}

/// One image of one tactile pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactileImage {
    /// 0, 1, 2 = fingertips F1, F2, F3; 3 = palm.
    pub pad: u8,
    /// Tick at which the pad was scanned.
    pub stamp: u32,
    /// Pressure per cell, N/cm^2, 0..15.996 in steps of 1/256; cell order as in the model's taxel table.
    pub pressure_n_cm2: [f32; PAD_CELLS],
}

/// What a hand motor is told to do; values at the joint (inner link or spread).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandCommand {
    /// No current; the worm gears of the fingers hold by themselves.
    Idle,
    /// Move to this joint angle (radians) at the drive's own speed and hold it.
    Position(f32),
    /// Move at this joint speed (rad/s, positive = closing); 0 holds.
    Velocity(f32),
    /// Push with this joint torque (newton-metres, positive = closing) as far as it goes.
    Torque(f32),
}

/// Commands of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointCommands {
    /// The tick of the readings that these answer.
    pub tick: u32,
    /// Arm joint torques, J1..J7, newton-metres.
    pub arm_tau_nm: [f32; ARM_JOINTS],
    /// Hand motors F1, F2, F3, spread.
    pub hand: [HandCommand; HAND_MOTORS],
}

impl JointCommands {
    /// The commands that do nothing: no torque, hand idle.
    pub fn idle(tick: u32) -> Self {
        Self { tick, arm_tau_nm: [0.0; ARM_JOINTS], hand: [HandCommand::Idle; HAND_MOTORS] }
    }
}
