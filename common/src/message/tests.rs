//! Promises of the wire structs.
use super::packed::{ARM_TORQUE_LSB_NM, TIP_LSB_NM};
use super::*;
use crate::limits::{ARM_JOINTS, HAND_MOTORS, PAD_CELLS};
use crate::pose::PlanarPose;
use crate::reading::{HandCommand, JointCommands, JointReadings, TactileImage, Validity};
use crate::robot::tables::PALM_FACE_Z_M;
use crate::shape::ObjectShape;
use nalgebra::Vector3;
use proptest::prelude::*;

fn readings(tick: u32, a: f32, t: f32) -> JointReadings {
    JointReadings {
        tick,
        arm_q_rad: [a, -a, 0.0, 3.1, -4.76, a * 0.5, -2.9],
        motor_q_rad: [0.1, a, 2.4, 3.1],
        inner_q_rad: [0.1, a, 2.4],
        effort_nm: [t, -t, 0.0, 1.0],
        tip_torque_nm: [t * 0.2, 0.0, -1.0],
        valid: Validity::ALL,
    }
}

#[test]
fn a_sensor_frame_fills_one_can_fd_frame() {
    let frame = SensorFrame::pack(&readings(u32::MAX, 1.0, 2.0));
    let mut buffer = [0; 128];
    let bytes = postcard::to_slice(&frame, &mut buffer).unwrap();
    assert_eq!(bytes.len(), SensorFrame::WIRE_LEN);
    assert_eq!(bytes.len() + 1, 64, "one tail byte more");
}

#[test]
fn a_command_has_its_fixed_length() {
    let mut c = JointCommands::idle(u32::MAX);
    c.hand = [HandCommand::Torque(8.0); HAND_MOTORS];
    c.arm_tau_nm = [127.0; ARM_JOINTS];
    let mut buffer = [0; 128];
    assert_eq!(postcard::to_slice(&Command::pack(&c), &mut buffer).unwrap().len(), Command::WIRE_LEN);
}

#[test]
fn a_value_that_is_not_finite_is_sent_as_not_measured() {
    let mut r = readings(7, 0.3, 0.1);
    r.arm_q_rad[2] = f32::NAN;
    r.tip_torque_nm[1] = f32::INFINITY;
    let back = SensorFrame::pack(&r).unpack();
    assert_eq!(back.valid.0, Validity::ALL.0 & !(1 << 2) & !(1 << 19));
    assert!(!back.valid.arm() && !back.valid.hand());
}

#[test]
fn a_hand_value_that_is_not_finite_becomes_idle() {
    let mut c = JointCommands::idle(1);
    c.hand[1] = HandCommand::Velocity(f32::NAN);
    assert_eq!(Command::pack(&c).unpack().unwrap().hand[1], HandCommand::Idle);
}

proptest! {
    #[test]
    fn readings_round_trip_within_half_a_count(tick: u32, a in -8.0_f32..8.0, t in -1.5_f32..1.5) {
        let r = readings(tick, a, t);
        let back = SensorFrame::pack(&r).unpack();
        prop_assert_eq!(back.tick, tick);
        for (x, y) in r.arm_q_rad.iter().zip(back.arm_q_rad) {
            prop_assert!((x - y).abs() <= 0.51e-6 + 1e-6, "{x} {y}");
        }
        for (x, y) in r.tip_torque_nm.iter().zip(back.tip_torque_nm) {
            prop_assert!((x - y).abs() <= 0.51 * TIP_LSB_NM);
        }
        prop_assert_eq!(back.valid, r.valid);
    }

    #[test]
    fn a_tactile_image_round_trips_to_the_bit(codes in prop::array::uniform24(0_u16..4096), pad in 0_u8..4, stamp: u32) {
        let image = TactileImage { pad, stamp, pressure_n_cm2: codes.map(|c| f32::from(c) / 256.0) };
        let slice = TactileSlice::pack(&image, stamp.wrapping_add(1));
        prop_assert_eq!(slice.unpack(), Some(image));
        prop_assert_eq!(slice.effective(), stamp.wrapping_add(1));
    }

    #[test]
    fn any_bytes_decode_to_a_message_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        // The promise is that none of these panics; what decodes must also survive its second step.
        if let Ok(m) = postcard::from_bytes::<SensorFrame>(&bytes) { let _ = m.unpack(); }
        if let Ok(m) = postcard::from_bytes::<TactileSlice>(&bytes) { let _ = m.unpack(); }
        if let Ok(m) = postcard::from_bytes::<Command>(&bytes) { let _ = m.unpack(); }
        let _ = postcard::from_bytes::<Setup>(&bytes);
        let _ = postcard::from_bytes::<PlanAnswer>(&bytes);
        let _ = postcard::from_bytes::<RolloutResult>(&bytes);
        let _ = postcard::from_bytes::<PlanRequest>(&bytes);
        let _ = postcard::from_bytes::<Event>(&bytes);
    }
}

#[test]
fn a_pad_that_the_hand_lacks_is_refused() {
    let image = TactileImage { pad: 9, stamp: 0, pressure_n_cm2: [0.0; PAD_CELLS] };
    assert_eq!(TactileSlice::pack(&image, 0).unpack(), None);
}

#[test]
fn values_beyond_the_range_saturate_and_keep_their_sign() {
    let mut c = JointCommands::idle(0);
    c.arm_tau_nm = [1e9, -1e9, 127.0, -127.0, f32::NAN, f32::INFINITY, 0.0];
    c.hand = [HandCommand::Torque(-1e9), HandCommand::Position(1e9), HandCommand::Velocity(-0.0), HandCommand::Idle];
    let back = Command::pack(&c).unpack().unwrap();
    let expected = [127.996, -127.996, 127.0, -127.0, 0.0, 127.996, 0.0];
    for (tau, wanted) in back.arm_tau_nm.iter().zip(expected) {
        assert!((tau - wanted).abs() < 1e-3, "{tau} {wanted}");
    }
    assert!(matches!(back.hand[0], HandCommand::Torque(t) if (t + 8.388607).abs() < 1e-5));
    assert!(matches!(back.hand[1], HandCommand::Position(q) if (q - 8.388607).abs() < 1e-5));
    assert_eq!(back.hand[2], HandCommand::Velocity(0.0));
}

proptest! {
    #[test]
    fn commands_round_trip_within_half_a_count(tick: u32, tau in prop::array::uniform7(-127.0_f32..127.0), v in -8.3_f32..8.3) {
        let hand = [HandCommand::Position(v), HandCommand::Velocity(-v), HandCommand::Torque(v), HandCommand::Idle];
        let back = Command::pack(&JointCommands { tick, arm_tau_nm: tau, hand }).unpack().unwrap();
        prop_assert_eq!(back.tick, tick);
        for (sent, got) in tau.iter().zip(back.arm_tau_nm) {
            prop_assert!((sent - got).abs() <= 0.5 * ARM_TORQUE_LSB_NM);
        }
        prop_assert!(matches!(back.hand[0], HandCommand::Position(q) if (q - v).abs() < 1.1e-6));
        prop_assert!(matches!(back.hand[1], HandCommand::Velocity(q) if (q + v).abs() < 1.1e-6));
        prop_assert!(matches!(back.hand[2], HandCommand::Torque(q) if (q - v).abs() < 1.1e-6));
    }

    #[test]
    fn pressures_below_zero_and_beyond_full_scale_saturate(p in prop::num::f32::ANY) {
        let mut image = TactileImage { pad: 0, stamp: 0, pressure_n_cm2: [0.0; PAD_CELLS] };
        image.pressure_n_cm2[5] = p;
        let back = TactileSlice::pack(&image, 0).unpack().unwrap().pressure_n_cm2;
        prop_assert!((0.0..=4095.0 / 256.0).contains(&back[5]));
        prop_assert!(back.iter().enumerate().all(|(cell, q)| cell == 5 || *q == 0.0), "neighbours are untouched");
    }

    #[test]
    fn the_hand_points_down_over_the_object_at_the_height_asked_for(x in -0.4_f32..0.4, phi in -3.0_f32..3.0, yaw in -3.0_f32..3.0, palm in 0.0_f32..0.2) {
        let shape = ObjectShape::THESIS_BOX;
        let placement = HandPlacement { hand_in_object: PlanarPose::new(0.02, -0.01, yaw), palm_height_m: palm };
        let object = PlanarPose::new(x, -0.1, phi);
        let pose = placement.world_from_hand(&object, &shape);
        let z = pose.rotation * Vector3::z();
        prop_assert!((z + Vector3::z()).norm() < 1e-5, "the palm looks down");
        let x_axis = pose.rotation * Vector3::x();
        prop_assert!(libm::sinf(libm::atan2f(x_axis.y, x_axis.x) - phi - yaw).abs() < 1e-4, "yaws add up");
        prop_assert!((pose.translation.z - PALM_FACE_Z_M - palm - shape.top_height_m()).abs() < 1e-5);
        let (s, c) = libm::sincosf(phi);
        prop_assert!((pose.translation.x - x - 0.02 * c - 0.01 * s).abs() < 1e-5);
        prop_assert!((pose.translation.y + 0.1 - 0.02 * s + 0.01 * c).abs() < 1e-5);
    }
}

#[test]
fn the_digest_is_fnv_1a_of_64_bits() {
    // Test vectors of the FNV reference.
    let of = |bytes: &[u8]| {
        let mut digest = Digest::default();
        digest.update(bytes);
        digest.0
    };
    assert_eq!(of(b""), 0xcbf2_9ce4_8422_2325);
    assert_eq!(of(b"a"), 0xaf63_dc4c_8601_ec8c);
    assert_eq!(of(b"foobar"), 0x8594_4171_f739_67e8);
}
