//! Counts and torque units, and the cables between motors and joints.
//!
//! Rounding is that of Barrett's library: positions of the arm and torques are rounded down, targets of the hand towards
//! zero. Conversions to integers saturate; a value that is not a number gives 0.

use super::packed::Counts;
use crate::limits::ARM_JOINTS;
use crate::robot::tables::{ARM_MOTOR_COUNTS, GEAR_INNER, GEAR_SPREAD, HAND_MOTOR_COUNTS, MOTOR_FROM_JOINT};
use core::f32::consts::TAU;

/// Torque units per newton-metre at the motor as the arm's pucks leave the factory, M1..M7. Single pucks differ (2562 on
/// M2 and M3 has been seen, and 4961 on M5 and M6): ask each.
pub const ARM_IPNM: [f32; ARM_JOINTS] = [2700.0, 2700.0, 2700.0, 2700.0, 6500.0, 6500.0, 17474.0];
/// Torque units per newton-metre at the motors of the hand.
pub const HAND_IPNM: f32 = 20_000.0;

/// Inverse of a matrix by Gauss and Jordan, with pivots; at compile time.
const fn inverse<const N: usize>(matrix: [[f32; N]; N]) -> [[f32; N]; N] {
    let (mut a, mut b) = ([[0.0_f64; N]; N], [[0.0_f64; N]; N]);
    let mut i = 0;
    while i < N {
        let mut j = 0;
        while j < N {
            a[i][j] = matrix[i][j] as f64;
            j += 1;
        }
        b[i][i] = 1.0;
        i += 1;
    }
    let mut column = 0;
    while column < N {
        let mut pivot = column;
        let mut row = column;
        while row < N {
            if a[row][column].abs() > a[pivot][column].abs() {
                pivot = row;
            }
            row += 1;
        }
        assert!(a[pivot][column].abs() > 1e-9, "motors and joints must determine each other");
        (a[column], a[pivot]) = (a[pivot], a[column]);
        (b[column], b[pivot]) = (b[pivot], b[column]);
        let mut row = 0;
        while row < N {
            let factor = a[row][column] / a[column][column];
            let mut j = 0;
            while row != column && j < N {
                a[row][j] -= factor * a[column][j];
                b[row][j] -= factor * b[column][j];
                j += 1;
            }
            row += 1;
        }
        column += 1;
    }
    let mut result = [[0.0; N]; N];
    let mut i = 0;
    while i < N {
        let mut j = 0;
        while j < N {
            result[i][j] = (b[i][j] / a[i][i]) as f32;
            j += 1;
        }
        i += 1;
    }
    result
}

/// Joint angles = this matrix (rows) times the motor angles; motor torques = its transpose times the joint torques.
pub const JOINT_FROM_MOTOR: [[f32; ARM_JOINTS]; ARM_JOINTS] = inverse(MOTOR_FROM_JOINT);

fn dot(row: &[f32; ARM_JOINTS], vector: &[f32; ARM_JOINTS]) -> f32 {
    row.iter().zip(vector).map(|(a, b)| a * b).sum()
}

/// Motor angles M1..M7 (radians) of joint angles J1..J7 (radians).
pub fn motors_from_joints(q_rad: &[f32; ARM_JOINTS]) -> [f32; ARM_JOINTS] {
    MOTOR_FROM_JOINT.each_ref().map(|row| dot(row, q_rad))
}

/// Joint angles (radians) of motor angles (radians).
pub fn joints_from_motors(motor_rad: &[f32; ARM_JOINTS]) -> [f32; ARM_JOINTS] {
    JOINT_FROM_MOTOR.each_ref().map(|row| dot(row, motor_rad))
}

/// Motor torques M1..M7 (newton-metres) that make joint torques J1..J7 (newton-metres).
pub fn motor_torques(tau_nm: &[f32; ARM_JOINTS]) -> [f32; ARM_JOINTS] {
    let mut motor_nm = [0.0; ARM_JOINTS];
    for (row, tau) in JOINT_FROM_MOTOR.iter().zip(tau_nm) {
        for (motor, share) in motor_nm.iter_mut().zip(row) {
            *motor += share * tau;
        }
    }
    motor_nm
}

/// Joint torques (newton-metres) that motor torques (newton-metres) make.
pub fn joint_torques(motor_nm: &[f32; ARM_JOINTS]) -> [f32; ARM_JOINTS] {
    let mut tau_nm = [0.0; ARM_JOINTS];
    for (row, motor) in MOTOR_FROM_JOINT.iter().zip(motor_nm) {
        for (tau, share) in tau_nm.iter_mut().zip(row) {
            *tau += share * motor;
        }
    }
    tau_nm
}

/// Encoder counts of an arm motor's angle.
pub fn arm_counts(motor_rad: f32) -> Counts {
    Counts::saturated(libm::floorf(motor_rad / TAU * ARM_MOTOR_COUNTS as f32) as i32)
}

/// Angle of an arm motor, radians.
pub fn arm_motor_rad(counts: Counts) -> f32 {
    counts.get() as f32 * (TAU / ARM_MOTOR_COUNTS as f32)
}

/// Torque of a motor in puck units (`ipnm` units per newton-metre).
pub fn torque_units(motor_nm: f32, ipnm: f32) -> i32 {
    libm::floorf(motor_nm * ipnm) as i32
}

/// Motor turns per turn of what a hand motor moves: inner link, or spread.
pub const HAND_GEARS: [f32; 4] = [GEAR_INNER, GEAR_INNER, GEAR_INNER, GEAR_SPREAD];

/// Counts of a hand motor for an angle of its joint (inner link or spread).
pub fn hand_counts(joint_rad: f32, gear: f32) -> i32 {
    (joint_rad / TAU * (HAND_MOTOR_COUNTS as f32 * gear)) as i32
}

/// Angle of the joint for counts of its hand motor or secondary encoder, `counts_per_turn` of which make a turn of what
/// carries the encoder.
pub fn hand_joint_rad(counts: Counts, counts_per_turn: u32, gear: f32) -> f32 {
    counts.get() as f32 * (TAU / (counts_per_turn as f32 * gear))
}

/// Velocity of a hand motor, counts per millisecond, for a speed of its joint.
pub fn hand_counts_per_ms(joint_rad_s: f32, gear: f32) -> i32 {
    (joint_rad_s / TAU * (HAND_MOTOR_COUNTS as f32 * gear) / 1000.0) as i32
}
