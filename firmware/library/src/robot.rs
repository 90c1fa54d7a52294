//! Readings and commands of one tick, and where the hand is.

use crate::geometry::TactusTransform;
use crate::handle::{Plain, needed, put};
use crate::result::{TactusResult, answer};
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PAD_CELLS, PADS, SILENCE_TICKS_MAX, TICK_US};
use tactus_common::reading::{HandCommand, JointCommands, JointReadings, TactileImage, Validity};
use tactus_common::robot::arm;
use tactus_common::robot::hand::HandAngles;

/// Length of one tick, microseconds: `tactus_controller_tick` is to be called this often.
pub const TACTUS_TICK_US: u32 = 2_000;
/// Ticks without readings after which the controller lets go of the robot.
pub const TACTUS_SILENCE_TICKS_MAX: u32 = 20;
/// Joints of the arm.
pub const TACTUS_ARM_JOINTS: usize = 7;
/// Motors of the hand: F1, F2, F3, spread.
pub const TACTUS_HAND_MOTORS: usize = 4;
/// Fingers of the hand: F1, F2, F3.
pub const TACTUS_FINGERS: usize = 3;
/// Tactile pads: fingertips F1, F2, F3, and the palm.
pub const TACTUS_PADS: usize = 4;
/// Cells of one tactile pad.
pub const TACTUS_PAD_CELLS: usize = 24;

const _: () = {
    assert!(TACTUS_TICK_US == TICK_US && TACTUS_SILENCE_TICKS_MAX == SILENCE_TICKS_MAX);
    assert!(TACTUS_ARM_JOINTS == ARM_JOINTS && TACTUS_HAND_MOTORS == HAND_MOTORS && TACTUS_FINGERS == FINGERS);
    assert!(TACTUS_PADS == PADS && TACTUS_PAD_CELLS == PAD_CELLS);
    assert!(TACTUS_VALID_ALL == Validity::ALL.0);
};

/// All seven arm angles were measured.
pub const TACTUS_VALID_ARM: u32 = 0x00_007f;
/// All four motor positions were measured.
pub const TACTUS_VALID_MOTORS: u32 = 0x00_0780;
/// All three inner-link angles were measured.
pub const TACTUS_VALID_INNER: u32 = 0x00_3800;
/// All four motor efforts were measured. The controller does without.
pub const TACTUS_VALID_EFFORTS: u32 = 0x03_c000;
/// All three fingertip torques were measured.
pub const TACTUS_VALID_TIPS: u32 = 0x1c_0000;
/// Everything was measured.
pub const TACTUS_VALID_ALL: u32 = 0x1f_ffff;

/// Joint readings of one tick. A value without its bit in `valid` is not used; one that is not finite makes the whole
/// reading count as not measured.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusReadings {
    /// Arm joint angles J1..J7, radians.
    pub arm_q_rad: [f32; TACTUS_ARM_JOINTS],
    /// Motor positions F1, F2, F3, spread as joint angles, radians: motor angle over the gear ratio to the inner link
    /// or the spread. Positive closes.
    pub motor_q_rad: [f32; TACTUS_HAND_MOTORS],
    /// Inner-link angles F1, F2, F3 by the secondary encoders, radians.
    pub inner_q_rad: [f32; TACTUS_FINGERS],
    /// Motor efforts F1, F2, F3, spread as torques at the joint, newton-metres, positive closes.
    pub effort_nm: [f32; TACTUS_HAND_MOTORS],
    /// Fingertip torques F1, F2, F3 about the distal joint, newton-metres; positive where the world pushes the tip open.
    pub tip_torque_nm: [f32; TACTUS_FINGERS],
    /// What was measured: bits 0-6 arm, 7-10 motors, 11-13 inner links, 14-17 efforts, 18-20 tips (`TACTUS_VALID_...`).
    pub valid: u32,
}

// SAFETY: numbers only.
unsafe impl Plain for TactusReadings {}

impl TactusReadings {
    pub(crate) fn to_rust(self, tick: u32) -> JointReadings {
        JointReadings {
            tick,
            arm_q_rad: self.arm_q_rad,
            motor_q_rad: self.motor_q_rad,
            inner_q_rad: self.inner_q_rad,
            effort_nm: self.effort_nm,
            tip_torque_nm: self.tip_torque_nm,
            valid: Validity(self.valid & Validity::ALL.0),
        }
    }
}

/// One image of one tactile pad.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusImage {
    /// Tick at which the pad was scanned.
    pub stamp: u32,
    /// Pressure per cell, N/cm^2, row by row. Values below 0 and values that are no number count as 0.
    pub pressure_n_cm2: [f32; TACTUS_PAD_CELLS],
    /// 0, 1, 2 = fingertips F1, F2, F3; 3 = palm.
    pub pad: u8,
}

// SAFETY: numbers only.
unsafe impl Plain for TactusImage {}

impl TactusImage {
    pub(crate) fn to_rust(self) -> TactileImage {
        // `max` answers the other number where one is none.
        let pressure_n_cm2 = self.pressure_n_cm2.map(|p| p.max(0.0));
        TactileImage { pad: self.pad, stamp: self.stamp, pressure_n_cm2 }
    }
}

/// What a motor of the hand is told to do.
#[repr(u8)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TactusHandMode {
    /// No current; the worm gears of the fingers hold by themselves. `value` is 0.
    #[default]
    Idle = 0,
    /// Move to the joint angle `value`, radians, at the drive's own speed and hold it.
    Position = 1,
    /// Move at the joint speed `value`, rad/s, positive closes; 0 holds.
    Velocity = 2,
    /// Push with the joint torque `value`, newton-metres, positive closes.
    Torque = 3,
}

/// Command of one motor of the hand; values at the joint (inner link or spread).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusHandCommand {
    /// What `value` means.
    pub mode: TactusHandMode,
    /// Radians, rad/s or newton-metres.
    pub value: f32,
}

impl From<HandCommand> for TactusHandCommand {
    fn from(command: HandCommand) -> Self {
        let (mode, value) = match command {
            HandCommand::Idle => (TactusHandMode::Idle, 0.0),
            HandCommand::Position(q_rad) => (TactusHandMode::Position, q_rad),
            HandCommand::Velocity(qd_rad_s) => (TactusHandMode::Velocity, qd_rad_s),
            HandCommand::Torque(tau_nm) => (TactusHandMode::Torque, tau_nm),
        };
        Self { mode, value }
    }
}

/// Commands of one tick.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusCommands {
    /// Arm joint torques J1..J7, newton-metres, within the joints' limits.
    pub arm_tau_nm: [f32; TACTUS_ARM_JOINTS],
    /// Motors of the hand F1, F2, F3, spread.
    pub hand: [TactusHandCommand; TACTUS_HAND_MOTORS],
}

impl From<&JointCommands> for TactusCommands {
    fn from(commands: &JointCommands) -> Self {
        Self { arm_tau_nm: commands.arm_tau_nm, hand: commands.hand.map(TactusHandCommand::from) }
    }
}

/// Where the hand is and how it is bent. Hand frame: origin on the mounting plane, z out of the palm, F3 at -x.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusHand {
    /// World-from-hand transform.
    pub world_from_hand: TactusTransform,
    /// Inner links F1, F2, F3, radians; 0 = in the palm's plane, positive closes.
    pub inner_rad: [f32; TACTUS_FINGERS],
    /// Tips F1, F2, F3 against their inner links, radians; 0 = fully open.
    pub distal_rad: [f32; TACTUS_FINGERS],
    /// Spread, radians; 0 = F1 and F2 opposite F3.
    pub spread_rad: f32,
}

// SAFETY: numbers only.
unsafe impl Plain for TactusHand {}

impl TactusHand {
    pub(crate) fn angles(&self) -> HandAngles {
        HandAngles { inner_rad: self.inner_rad, distal_rad: self.distal_rad, spread_rad: self.spread_rad }
    }
}

/// Where the hand of the WAM arm is and how it is bent, from joint readings (arm, motors and inner links).
///
/// `TACTUS_RESULT_BAD_VALUE` if one of these was not measured or is not finite.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tactus_hand_from_readings(
    readings: *const TactusReadings,
    hand: *mut TactusHand,
) -> TactusResult {
    const NEEDED: u32 = TACTUS_VALID_ARM | TACTUS_VALID_MOTORS | TACTUS_VALID_INNER;
    // SAFETY: the header's contract for both pointers.
    answer(unsafe { needed(readings) }.and_then(|r| {
        let mut angles = r.arm_q_rad.iter().chain(&r.motor_q_rad).chain(&r.inner_q_rad);
        if r.valid & NEEDED != NEEDED || !angles.all(|q| q.is_finite()) {
            return Err(TactusResult::BadValue);
        }
        let bent = HandAngles::from_readings(&r.motor_q_rad, &r.inner_q_rad);
        let found = TactusHand {
            world_from_hand: (&arm::hand_pose(&r.arm_q_rad)).into(),
            inner_rad: bent.inner_rad,
            distal_rad: bent.distal_rad,
            spread_rad: bent.spread_rad,
        };
        // SAFETY: as above.
        unsafe { put(hand, found) }
    }))
}
