use super::super::tables::{ARM_LIMITS, SHOULDER_HEIGHT_M};
use super::*;

/// A configuration within the limits, from a fixed sequence.
pub(crate) fn sample(state: &mut u32) -> [f32; 7] {
    let mut q = [0.0; 7];
    for (value, limit) in q.iter_mut().zip(&ARM_LIMITS) {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let unit = (*state >> 8) as f32 / (1 << 24) as f32;
        *value = limit.lower_rad + unit * (limit.upper_rad - limit.lower_rad);
    }
    q
}

#[test]
fn at_zero_the_arm_stands_straight_up() {
    let hand = link_poses_from(&Isometry3::identity(), &[0.0; 7])[7];
    let expected = Vector3::new(0.0, 0.0, SHOULDER_HEIGHT_M + 0.91);
    assert!((hand.translation.vector - expected).norm() < 1e-6, "{hand}");
    assert!(hand.rotation.angle() < 1e-6);
}

#[test]
fn positive_j2_and_j4_lean_forward() {
    for joint in [1, 3] {
        let mut q = [0.0; 7];
        q[joint] = 0.2;
        assert!(link_poses_from(&Isometry3::identity(), &q)[7].translation.x > 0.05, "J{}", joint + 1);
    }
}

/// Facts 4.4, hand pointing straight down, flange 0.245 above the base's bottom: radius, q2, q4, q6; then 0.345 above.
const STRAIGHT_DOWN: [([f32; 4], f32); 8] = [
    ([0.45, 0.9983, 2.4134, -0.2701], 0.245),
    ([0.50, 0.9944, 2.2488, -0.1016], 0.245),
    ([0.60, 1.0319, 1.9057, 0.2041], 0.245),
    ([0.65, 1.0694, 1.7187, 0.3535], 0.245),
    ([0.70, 1.1199, 1.5132, 0.5084], 0.245),
    ([0.75, 1.1866, 1.2769, 0.6780], 0.245),
    ([0.65, 0.9173, 1.7133, 0.5110], 0.345),
    ([0.70, 0.9790, 1.5076, 0.6550], 0.345),
];

#[test]
fn the_published_straight_down_configurations_are_met() {
    for ([radius, q2, q4, q6], height) in STRAIGHT_DOWN {
        let hand = link_poses_from(&Isometry3::identity(), &[0.0, q2, 0.0, q4, 0.0, q6, 0.0])[7];
        let expected = Vector3::new(radius, 0.0, height);
        // The table has four decimals: half a unit in each angle moves the flange by at most 0.05 mm x lever sum.
        assert!((hand.translation.vector - expected).norm() < 2e-4, "r {radius}: {}", hand.translation);
        assert!((hand * Vector3::z() + Vector3::z()).norm() < 2e-4, "r {radius} points down");
        assert!((hand * Vector3::x() + Vector3::x()).norm() < 2e-4, "r {radius}: q7 = 0 puts x toward the robot");
    }
}

#[test]
fn the_mounted_arm_faces_the_table() {
    // Mount: axis of J1 at (-0.05, -0.6), +x of the base to world +y.
    let hand = hand_pose(&[0.0, 1.0694, 0.0, 1.7187, 0.0, 0.3535, 0.0]);
    assert!((hand.translation.vector - Vector3::new(-0.05, 0.05, 0.245)).norm() < 2e-4, "{hand}");
}

#[test]
fn a_base_that_stands_elsewhere_takes_the_whole_arm_along() {
    let mut state = 5;
    for (mount, q) in [(PlanarPose::new(0.4, 0.7, -1.2), sample(&mut state)), (MOUNT, sample(&mut state))] {
        let from_base = link_poses_from(&Isometry3::identity(), &q)[7];
        let apart = hand_pose_from(&mount, &q).inverse() * (mount.isometry(MOUNT_XYZ_M[2]) * from_base);
        assert!(apart.translation.vector.norm() < 1e-5 && apart.rotation.angle() < 1e-3, "{apart}");
    }
    assert_eq!(hand_pose(&[0.1; 7]), hand_pose_from(&MOUNT, &[0.1; 7]));
}

#[test]
fn the_jacobian_agrees_with_differences() {
    let mut state = 7;
    for _ in 0..200 {
        let q = sample(&mut state);
        let j = jacobian(&q);
        let h = 2e-3;
        for joint in 0..7 {
            let (mut a, mut b) = (q, q);
            a[joint] -= h;
            b[joint] += h;
            let (a, b) = (hand_pose(&a), hand_pose(&b));
            let linear = (b.translation.vector - a.translation.vector) / (2.0 * h);
            let angular = (b.rotation * a.rotation.inverse()).scaled_axis() / (2.0 * h);
            assert!((linear - j.fixed_view::<3, 1>(0, joint)).norm() < 1e-3, "J{joint} {linear}");
            assert!((angular - j.fixed_view::<3, 1>(3, joint)).norm() < 1e-3, "J{joint} {angular}");
        }
    }
}
