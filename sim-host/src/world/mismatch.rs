//! How reality differs from what the mental model believes.

use super::noise::Noise;
use super::robot::RobotScales;
use crate::scenario::format::{MismatchScales, NoiseScales};

/// Factors and offsets on the nominal world. The controller and the mental model never see them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mismatch {
    /// Factor on the friction between object and table.
    pub table_friction: f32,
    /// Factor on the friction between pads and object.
    pub pad_friction: f32,
    /// Factor on the object's mass.
    pub object_mass: f32,
    /// Added to each full dimension of the object, metres.
    pub object_size_m: [f32; 3],
    /// Arm and hand masses, damping and friction.
    pub robot: RobotScales,
    /// Factor on the torque at which a finger's clutch lets go.
    pub breakaway: [f32; 3],
    /// Pressure below which a tactile cell reads 0, N/cm^2.
    pub tactile_threshold_n_cm2: f32,
    /// Noise of a tactile cell, standard deviation, N/cm^2.
    pub tactile_noise_n_cm2: f32,
    /// Factor on each pad's pressures.
    pub tactile_gain: [f32; 4],
    /// Offset of each strain gauge, N m.
    pub tip_torque_offset_nm: [f32; 3],
    /// Noise of the strain gauges, standard deviation, N m.
    pub tip_torque_noise_nm: f32,
    /// Noise of the motor efforts (current and friction), standard deviation, N m.
    pub effort_noise_nm: f32,
    /// Ticks by which commands act late.
    pub latency_ticks: u32,
}

impl Mismatch {
    /// The nominal world: no noise, no offset, no latency.
    pub const fn none() -> Self {
        Self {
            table_friction: 1.0,
            pad_friction: 1.0,
            object_mass: 1.0,
            object_size_m: [0.0; 3],
            robot: RobotScales::NOMINAL,
            breakaway: [1.0; 3],
            tactile_threshold_n_cm2: 0.05,
            tactile_noise_n_cm2: 0.0,
            tactile_gain: [1.0; 4],
            tip_torque_offset_nm: [0.0; 3],
            tip_torque_noise_nm: 0.0,
            effort_noise_nm: 0.0,
            latency_ticks: 0,
        }
    }

    /// A world drawn by seed: friction +-30 %, object mass +-20 % and +-1 mm a dimension, link masses +-5 %, joint
    /// damping +-30 %, dry friction +-50 %, clutches +-20 %, tactile threshold 0.03..0.08 N/cm^2, noise 0.005..0.015 N/cm^2
    /// and gain +-10 %, gauges +-3 mN m offset and 1..2 mN m noise, efforts 10..30 mN m noise, one tick of latency.
    pub fn from_seed(seed: u64) -> Self {
        let mut n = Noise::new(seed ^ 0x6d69_736d_6174_6368);
        let size_m = 0.001;
        Self {
            table_friction: n.factor(0.3),
            pad_friction: n.factor(0.3),
            object_mass: n.factor(0.2),
            object_size_m: [size_m * n.symmetric(), size_m * n.symmetric(), size_m * n.symmetric()],
            robot: RobotScales {
                arm_mass: core::array::from_fn(|_| n.factor(0.05)),
                hand_mass: core::array::from_fn(|_| n.factor(0.05)),
                arm_damping: core::array::from_fn(|_| n.factor(0.3)),
                arm_friction: core::array::from_fn(|_| n.factor(0.5)),
            },
            breakaway: core::array::from_fn(|_| n.factor(0.2)),
            tactile_threshold_n_cm2: 0.03 + 0.05 * n.unit(),
            tactile_noise_n_cm2: 0.005 + 0.01 * n.unit(),
            tactile_gain: core::array::from_fn(|_| n.factor(0.1)),
            tip_torque_offset_nm: core::array::from_fn(|_| 0.003 * n.symmetric()),
            tip_torque_noise_nm: 0.001 + 0.001 * n.unit(),
            effort_noise_nm: 0.01 + 0.02 * n.unit(),
            latency_ticks: 1,
        }
    }
}

impl Mismatch {
    /// This world's differences from the nominal one made larger or smaller: each of them multiplied by its scale, noise
    /// by its own. Scales of 1 change nothing.
    pub fn scaled(&self, noise: &NoiseScales, scales: &MismatchScales) -> Self {
        let nominal = Self::none();
        let (robot, nominal_robot) = (&self.robot, RobotScales::NOMINAL);
        Self {
            table_friction: towards(nominal.table_friction, self.table_friction, scales.friction),
            pad_friction: towards(nominal.pad_friction, self.pad_friction, scales.friction),
            object_mass: towards(nominal.object_mass, self.object_mass, scales.mass),
            object_size_m: all_towards(&nominal.object_size_m, &self.object_size_m, scales.size),
            robot: RobotScales {
                arm_mass: all_towards(&nominal_robot.arm_mass, &robot.arm_mass, scales.robot),
                hand_mass: all_towards(&nominal_robot.hand_mass, &robot.hand_mass, scales.robot),
                arm_damping: all_towards(&nominal_robot.arm_damping, &robot.arm_damping, scales.robot),
                arm_friction: all_towards(&nominal_robot.arm_friction, &robot.arm_friction, scales.robot),
            },
            breakaway: all_towards(&nominal.breakaway, &self.breakaway, scales.robot),
            tactile_threshold_n_cm2: towards(
                nominal.tactile_threshold_n_cm2,
                self.tactile_threshold_n_cm2,
                scales.sensors,
            ),
            tactile_noise_n_cm2: self.tactile_noise_n_cm2 * noise.tactile,
            tactile_gain: all_towards(&nominal.tactile_gain, &self.tactile_gain, scales.sensors),
            tip_torque_offset_nm: all_towards(
                &nominal.tip_torque_offset_nm,
                &self.tip_torque_offset_nm,
                scales.sensors,
            ),
            tip_torque_noise_nm: self.tip_torque_noise_nm * noise.tip_torque,
            effort_noise_nm: self.effort_noise_nm * noise.effort,
            latency_ticks: libm::roundf(self.latency_ticks as f32 * scales.latency) as u32,
        }
    }
}

/// The value that differs from `nominal` by `scale` times as much as `drawn` does.
fn towards(nominal: f32, drawn: f32, scale: f32) -> f32 {
    // To the bit the drawn value, and not one rounded twice.
    if scale == 1.0 { drawn } else { nominal + scale * (drawn - nominal) }
}

fn all_towards<const N: usize>(nominal: &[f32; N], drawn: &[f32; N], scale: f32) -> [f32; N] {
    core::array::from_fn(|i| towards(nominal[i], drawn[i], scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_of_one_change_nothing_and_of_zero_leave_the_nominal_world() {
        let none = MismatchScales { friction: 0.0, mass: 0.0, size: 0.0, robot: 0.0, sensors: 0.0, latency: 0.0 };
        let silent = NoiseScales { tactile: 0.0, tip_torque: 0.0, effort: 0.0 };
        for seed in 0..50 {
            let drawn = Mismatch::from_seed(seed);
            assert_eq!(drawn.scaled(&NoiseScales::ONE, &MismatchScales::ONE), drawn);
            assert_eq!(drawn.scaled(&silent, &none), Mismatch::none());
            let half = drawn.scaled(&NoiseScales::ONE, &MismatchScales { friction: 0.5, ..MismatchScales::ONE });
            assert!((half.table_friction - 1.0 - 0.5 * (drawn.table_friction - 1.0)).abs() < 1e-6);
            assert_eq!(half.object_mass, drawn.object_mass);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_world_and_others_differ_within_bounds() {
        assert_eq!(Mismatch::from_seed(3), Mismatch::from_seed(3));
        let mut frictions = Vec::new();
        for seed in 0..200 {
            let m = Mismatch::from_seed(seed);
            assert!((m.table_friction - 1.0).abs() <= 0.3 && (m.object_mass - 1.0).abs() <= 0.2);
            assert!(m.object_size_m.iter().all(|s| s.abs() <= 0.001));
            assert!(m.robot.arm_mass.iter().chain(&m.robot.hand_mass).all(|f| (f - 1.0).abs() <= 0.05));
            frictions.push(m.table_friction);
        }
        frictions.sort_by(f32::total_cmp);
        assert!(frictions[10] < 0.75 && frictions[190] > 1.25, "the whole range is used");
    }
}
