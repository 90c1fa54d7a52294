//! How reality differs from what the mental model believes.

use super::noise::Noise;
use super::robot::RobotScales;

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

#[cfg(test)]
mod tests {
    use super::*;

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
