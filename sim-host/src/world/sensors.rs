//! Joint sensors: encoders with their real steps, strain gauges and motor efforts with noise.

use super::hand::HandDrives;
use super::mismatch::Mismatch;
use super::model::RobotModel;
use super::noise::Noise;
use nalgebra::{SMatrix, SVector};
use tactus_common::reading::{JointReadings, Validity};

/// Resolution of every joint sensor.
#[derive(Clone, Debug)]
pub struct Sensors {
    motor_from_joint: SMatrix<f64, 7, 7>,
    joint_from_motor: SMatrix<f64, 7, 7>,
    arm_count_rad: f64,
    finger_count_rad: f64,
    spread_count_rad: f64,
    inner_count_rad: f64,
    tip_count_nm: f32,
    tip_range_nm: f32,
    tip_offset_nm: [f32; 3],
    tip_noise_nm: f32,
    effort_noise_nm: f32,
}

/// One count of the motors' current, as a torque at a finger's joint, N m (12 bits over the peak). Assumed.
const EFFORT_COUNT_NM: f32 = 0.0025;

fn quantised(value: f64, count: f64) -> f64 {
    libm::round(value / count) * count
}

impl Sensors {
    /// The sensors of a model.
    pub fn new(model: &RobotModel, mismatch: &Mismatch) -> Option<Self> {
        let (arm, drive, gauge) = (&model.extra.arm, &model.extra.hand.drive, &model.extra.hand.tip_torque);
        let motor_from_joint = SMatrix::<f64, 7, 7>::from_fn(|i, j| arm.motor_from_joint[i][j]);
        let turn = core::f64::consts::TAU;
        let motor_count = turn / f64::from(drive.motor_counts_per_turn);
        Some(Self {
            motor_from_joint,
            joint_from_motor: motor_from_joint.try_inverse()?,
            arm_count_rad: turn / f64::from(arm.encoder_counts_per_motor_turn),
            finger_count_rad: motor_count / f64::from(drive.gear_inner),
            spread_count_rad: motor_count / f64::from(drive.gear_spread),
            inner_count_rad: turn / f64::from(drive.secondary_counts_per_turn) / f64::from(drive.gear_secondary),
            tip_count_nm: gauge.resolution_nm,
            tip_range_nm: gauge.range_nm,
            tip_offset_nm: mismatch.tip_torque_offset_nm,
            tip_noise_nm: mismatch.tip_torque_noise_nm,
            effort_noise_nm: mismatch.effort_noise_nm,
        })
    }

    /// One tick's readings of the true state. `tip_torque_nm` and `effort_nm` are the tick's means.
    pub fn read(
        &self,
        tick: u32,
        arm_q_rad: &[f32; 7],
        drives: &HandDrives,
        tip_torque_nm: &[f32; 3],
        effort_nm: &[f32; 4],
        noise: &mut Noise,
    ) -> JointReadings {
        // The arm's encoders sit on the motors; differentials mix two joints into two motors.
        let motors = self.motor_from_joint * SVector::<f64, 7>::from_fn(|i, _| f64::from(arm_q_rad[i]));
        let joints = self.joint_from_motor * motors.map(|m| quantised(m, self.arm_count_rad));
        let mut readings = JointReadings {
            tick,
            arm_q_rad: core::array::from_fn(|i| joints[i] as f32),
            motor_q_rad: [0.0; 4],
            inner_q_rad: [0.0; 3],
            effort_nm: [0.0; 4],
            tip_torque_nm: [0.0; 3],
            valid: Validity::ALL,
        };
        for (f, torque_nm) in tip_torque_nm.iter().enumerate() {
            readings.motor_q_rad[f] = quantised(f64::from(drives.fingers[f].motor.q_rad), self.finger_count_rad) as f32;
            readings.inner_q_rad[f] = quantised(f64::from(drives.inner[f].q_rad), self.inner_count_rad) as f32;
            let felt = torque_nm + self.tip_offset_nm[f] + self.tip_noise_nm * noise.normal();
            let counts = libm::roundf(felt.clamp(-self.tip_range_nm, self.tip_range_nm) / self.tip_count_nm);
            readings.tip_torque_nm[f] = counts * self.tip_count_nm;
        }
        readings.motor_q_rad[3] = quantised(f64::from(drives.spread.q_rad), self.spread_count_rad) as f32;
        for (out, effort) in readings.effort_nm.iter_mut().zip(effort_nm) {
            let felt = effort + self.effort_noise_nm * noise.normal();
            *out = libm::roundf(felt / EFFORT_COUNT_NM) * EFFORT_COUNT_NM;
        }
        readings
    }
}
