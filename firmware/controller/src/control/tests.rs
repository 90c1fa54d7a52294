//! Promises of the position law.

use super::*;
use crate::executor::{Executor, Motion, still};
use crate::testing::{ArmSim, Joints, home, through};
use proptest::prelude::*;
use tactus_common::robot::dynamics::gravity;

#[test]
fn at_rest_on_its_reference_the_torques_are_gravity_alone() {
    for payload_kg in [0.0, 0.6] {
        let mut control = JointControl::default();
        control.observe(0, &home());
        control.observe(1, &home());
        let tau_nm = control.torques(&home(), &still(home()), payload_kg);
        let weight_nm = gravity(&home(), payload_kg);
        for j in 0..ARM_JOINTS {
            assert!((tau_nm[j] - weight_nm[j]).abs() < 1e-3, "J{}: {} {}", j + 1, tau_nm[j], weight_nm[j]);
        }
    }
}

#[test]
fn a_joint_off_its_reference_is_pushed_back_and_a_moving_one_braked() {
    let control = JointControl::default();
    let weight_nm = control.torques(&home(), &still(home()), 0.0);
    for j in 0..ARM_JOINTS {
        let mut target = home();
        target[j] += 1e-3;
        let pushed_nm = control.torques(&home(), &still(target), 0.0)[j];
        assert!((pushed_nm - weight_nm[j] - 1e-3 * ARM_KP_NM_RAD[j]).abs() < 1e-3, "J{}", j + 1);
        let mut moving = JointControl::default();
        moving.qd_rad_s[j] = 0.1;
        assert!(moving.torques(&home(), &still(home()), 0.0)[j] < weight_nm[j], "J{}", j + 1);
    }
}

#[test]
fn the_velocity_estimate_finds_a_steady_speed_and_a_gap_does_not_change_it() {
    let mut control = JointControl::default();
    let at = |tick: u32| -> Joints { core::array::from_fn(|j| 0.1 * (j as f32 + 1.0) * tick as f32 * TICK_S) };
    let check = |control: &JointControl| {
        for (j, qd_rad_s) in control.velocity_rad_s().iter().enumerate() {
            assert!((qd_rad_s - 0.1 * (j as f32 + 1.0)).abs() < 2e-3, "J{}: {qd_rad_s}", j + 1);
        }
    };
    (0..30).for_each(|tick| control.observe(tick, &at(tick)));
    check(&control);
    // 19 ticks without readings: the most that the supervisor bridges.
    control.observe(49, &at(49));
    check(&control);
    control.observe(49, &[9.0; ARM_JOINTS]);
    control.observe(12, &[9.0; ARM_JOINTS]);
    check(&control);
}

#[test]
fn an_arm_moved_by_these_torques_follows_a_motion_within_three_milliradians() {
    let trajectory = through(1, &[home(), home().map(|q| q + 0.3), home().map(|q| q + 0.25)], 0.5);
    let mut executor = Executor::holding(home());
    executor.load(&trajectory).expect("sound");
    let (mut arm, mut control) = (ArmSim::at(home()), JointControl::default());
    let mut worst_rad = 0.0_f32;
    for tick in 0..1_500 {
        executor.enter_guarded();
        control.observe(tick, &arm.q_rad);
        let reference = executor.tick();
        arm.step(&control.torques(&arm.q_rad, &reference, 0.0), 0.0);
        for j in 0..ARM_JOINTS {
            worst_rad = worst_rad.max((arm.q_rad[j] - reference.q_rad[j]).abs());
        }
    }
    assert_eq!(executor.motion(), Motion::Holding);
    assert!(worst_rad < 3e-3, "{worst_rad}");
}

#[test]
fn an_unknown_load_moves_no_joint_by_more_than_20_mrad_and_the_arm_comes_to_rest() {
    let (mut arm, mut control) = (ArmSim::at(home()), JointControl::default());
    for tick in 0..3_000 {
        control.observe(tick, &arm.q_rad);
        arm.step(&control.torques(&arm.q_rad, &still(home()), 0.0), 0.6);
    }
    for j in 0..ARM_JOINTS {
        assert!((arm.q_rad[j] - home()[j]).abs() < 0.02 && arm.qd_rad_s[j].abs() < 1e-3, "J{}: {arm:?}", j + 1);
    }
}

proptest! {
    #[test]
    fn torques_are_finite_and_within_limits_for_any_input(bits in prop::collection::vec(any::<u32>(), 36)) {
        let joints = |from: usize| -> Joints { core::array::from_fn(|j| f32::from_bits(bits[from + j])) };
        let mut control = JointControl::default();
        control.observe(0, &joints(0));
        control.observe(bits[35], &joints(7));
        let reference = Sample { q_rad: joints(14), qd_rad_s: joints(21), qdd_rad_s2: joints(28) };
        for (j, tau_nm) in control.torques(&joints(7), &reference, 0.6).iter().enumerate() {
            prop_assert!(tau_nm.abs() <= ARM_LIMITS[j].torque_nm, "J{}: {tau_nm}", j + 1);
        }
    }
}
