//! Promises of the wire structs.
use super::*;
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
