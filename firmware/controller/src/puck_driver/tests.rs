//! Promises of the driver to the real arm, frame by frame.

extern crate std;

mod starting;

use super::startup::Startup;
use super::*;
use core::f32::consts::FRAC_PI_2;
use proptest::prelude::*;
use std::string::String;
use std::vec::Vec;
use tactus_common::can::Mtu;
use tactus_common::puck::Value;
use tactus_common::puck::property::motor;
use tactus_common::puck::tactile::FullFrame;
use tactus_common::reading::HandCommand;

fn show(frames: &[CanFrame]) -> Vec<String> {
    frames.iter().map(|frame| std::format!("{frame:?}")).collect()
}

fn begin(driver: &mut PuckDriver, tick: u32) -> Vec<String> {
    let mut sent = Vec::new();
    driver.begin(tick, &mut |frame| sent.push(frame));
    show(&sent)
}

fn command(driver: &mut PuckDriver, commands: &JointCommands) -> Vec<String> {
    let mut sent = Vec::new();
    driver.command(commands, &mut |frame| sent.push(frame));
    show(&sent)
}

fn report(from: Node, feedback: Feedback) -> CanFrame {
    Report::new(from, feedback).expect("a puck").frame()
}

fn position(from: Node, primary: i32, secondary: Option<i32>) -> CanFrame {
    let counts = |n| Counts::new(n).expect("22 bits");
    report(from, Feedback::Position(Position { primary: counts(primary), secondary: secondary.map(counts) }))
}

fn gauge(finger: usize, counts: i16) -> CanFrame {
    report(Node::HAND[finger], Feedback::Value(motor::SG, Value::Short(counts)))
}

/// All that a tick asks for; motors at 1000 counts times their number.
fn answer(driver: &mut PuckDriver) {
    for (m, node) in Node::ARM.iter().enumerate() {
        assert!(driver.receive(&position(*node, 1000 * (m as i32 + 1), None)));
    }
    for (m, node) in Node::HAND.iter().enumerate() {
        match driver.asks_positions() {
            true => assert!(driver.receive(&position(*node, 10_000 * (m as i32 + 1), Some(4_000 * (m as i32 + 1))))),
            false => assert!(driver.receive(&gauge(m, 2_100))),
        }
    }
}

/// A driver at tick 11 to which everything has been told.
fn running() -> PuckDriver {
    let mut driver = PuckDriver::new(Calibration::default());
    for tick in 10..12 {
        begin(&mut driver, tick);
        answer(&mut driver);
    }
    driver
}

const EFFORTS: u32 = 0b1111 << 14;

#[test]
fn even_ticks_ask_the_hand_for_positions_and_odd_ones_for_gauges() {
    let mut driver = PuckDriver::new(Calibration::default());
    assert_eq!(begin(&mut driver, 4), ["404#30", "405#30"]);
    assert_eq!(begin(&mut driver, 5), ["404#30", "405#19"]);
}

#[test]
fn everything_but_the_efforts_is_measured_in_si_units_once_two_ticks_have_been_answered() {
    let driver = running();
    let r = driver.readings().expect("something came");
    assert_eq!((r.tick, r.valid), (11, Validity(Validity::ALL.0 & !EFFORTS)));
    assert!(r.valid.arm() && r.valid.hand());
    let near = |a: f32, b: f64| f64::from(a) - b < 1e-6 && b - f64::from(a) < 1e-6;
    // J1 = -M1 / 42, J2 = (M2 - M3) / (2 * 28.25), J3 = -(M2 + M3) / (2 * 16.8155), J4 = -M4 / 18, J5 = (M5 + M6) / 19.4,
    // J6 = (M6 - M5) / 19.4, J7 = -M7 / 14.93, of motors at 1000 n counts of 4096.
    let turn = core::f64::consts::TAU * 1000.0 / 4096.0;
    let joints = [-1.0 / 42.0, -1.0 / 56.5, -5.0 / 33.631, -4.0 / 18.0, 11.0 / 19.4, 1.0 / 19.4, -7.0 / 14.93];
    assert!((0..7).all(|j| near(r.arm_q_rad[j], turn * joints[j])), "{:?}", r.arm_q_rad);
    assert!((0..3).all(|f| near(r.motor_q_rad[f], 10.0 * turn * (f as f64 + 1.0) / 125.0)), "{:?}", r.motor_q_rad);
    assert!(near(r.motor_q_rad[3], 40.0 * turn / 17.5));
    assert!((0..3).all(|f| near(r.inner_q_rad[f], 4.0 * turn * (f as f64 + 1.0) / 50.0)), "{:?}", r.inner_q_rad);
    assert!(r.tip_torque_nm.iter().all(|tau| near(*tau, 0.0816)), "{:?}", r.tip_torque_nm);
    assert_eq!(driver.stats(), PuckStats { incomplete_ticks: 0, ..driver.stats() });
}

#[test]
fn the_driver_is_small() {
    let bytes = [size_of::<PuckDriver>(), size_of::<Startup>()];
    std::println!("driver {}, start-up {} bytes", bytes[0], bytes[1]);
    assert!(bytes[0] <= 1_536 && bytes[1] <= 192, "{bytes:?}");
}

#[test]
fn before_the_first_answers_and_after_silence_there_are_no_readings_at_all() {
    let mut driver = PuckDriver::new(Calibration::default());
    assert_eq!(driver.readings(), None);
    let mut driver_running = running();
    begin(&mut driver, 0);
    begin(&mut driver_running, 12);
    assert_eq!((driver.readings(), driver_running.readings()), (None, None));
}

#[test]
fn a_missing_motor_unsets_the_joints_that_hang_on_it_and_no_others() {
    let joints: [u32; 7] = [0b000_0001, 0b000_0110, 0b000_0110, 0b000_1000, 0b011_0000, 0b011_0000, 0b100_0000];
    for (missing, hanging) in joints.iter().enumerate() {
        let mut driver = running();
        begin(&mut driver, 12);
        for (m, node) in Node::ARM.iter().enumerate().filter(|(m, _)| *m != missing) {
            driver.receive(&position(*node, 1000 * (m as i32 + 1), None));
        }
        let readings = driver.readings().expect("the others came");
        assert_eq!(readings.valid.0 & 0x7f, 0x7f & !*hanging, "without M{}", missing + 1);
        assert!(!driver.is_complete());
        begin(&mut driver, 13);
        assert_eq!(driver.stats().incomplete_ticks, 1);
    }
}

#[test]
fn a_reading_of_the_hand_may_be_one_tick_old_and_no_older() {
    let mut driver = running();
    let hand = |driver: &PuckDriver| driver.readings().expect("the arm answers").valid.0 >> 7 & !(EFFORTS >> 7);
    for (tick, expected) in [(12, 0b1110_0000_0000_0000 >> 2), (13, 0)] {
        begin(&mut driver, tick);
        Node::ARM.iter().for_each(|node| assert!(driver.receive(&position(*node, 0, None))));
        assert_eq!(hand(&driver), expected, "tick {tick}");
    }
    // The bits of the gauges are 18-20: 11-13 above bit 7.
    assert_eq!(0b1110_0000_0000_0000 >> 2, 0b111 << 11);
}

#[test]
fn a_hand_without_second_encoders_has_no_inner_angles() {
    let mut driver = running();
    begin(&mut driver, 12);
    for node in Node::ARM.iter().chain(&Node::HAND) {
        driver.receive(&position(*node, 0, None));
    }
    begin(&mut driver, 13);
    answer(&mut driver);
    let readings = driver.readings().expect("answered");
    assert_eq!(readings.valid.0 >> 11 & 0b111, 0);
    assert!(!readings.valid.hand());
    // Told alone, they count.
    Node::HAND[..3].iter().for_each(|node| {
        let told = Feedback::Secondary(Counts::new(4_000).expect("22 bits"));
        assert!(driver.receive(&report(*node, told)));
    });
    assert!(driver.readings().expect("answered").valid.hand());
}

#[test]
fn a_gauge_beyond_12_bits_is_not_a_measurement() {
    for counts in [-1, 4_096, i16::MAX] {
        let mut driver = running();
        begin(&mut driver, 13);
        assert!(!driver.receive(&gauge(1, counts)), "{counts}");
        assert_eq!(driver.stats().bad, 1);
        assert!(driver.receive(&gauge(1, 4_095)) && driver.receive(&gauge(1, 0)));
        let tip_nm = driver.readings().expect("heard").tip_torque_nm[1];
        assert!((tip_nm + 2_000.0 * 0.000816).abs() < 1e-6, "{tip_nm}");
    }
}

#[test]
fn torques_go_out_in_two_frames_with_each_motors_own_unit() {
    let calibration =
        Calibration { arm_ipnm: [2700.0, 2562.0, 2562.0, 2700.0, 6500.0, 6500.0, 17474.0], ..Calibration::default() };
    let mut driver = PuckDriver::new(calibration);
    begin(&mut driver, 0);
    let commands = JointCommands {
        arm_tau_nm: [8.4e-14, 16.0262, -0.4130, -4.3880, -0.0539, -0.2261, -0.0007],
        ..JointCommands::idle(0)
    };
    let sent = command(&mut driver, &commands);
    assert_eq!(sent[..2], ["401#AAFFFC2F6F520292", "402#AA00E7FA20000000"]);
}

#[test]
fn the_hand_is_told_targets_and_modes_and_only_what_has_changed() {
    let mut driver = running();
    let commands = |hand| JointCommands { hand, ..JointCommands::idle(12) };
    let closing = commands([
        HandCommand::Velocity(0.75),
        HandCommand::Position(2.4),
        HandCommand::Torque(0.701),
        HandCommand::Idle,
    ]);
    begin(&mut driver, 12);
    // What is to stand first, then by number, two motors a tick: the spread idle, F1 at 61 counts/ms in velocity mode.
    assert_eq!(command(&mut driver, &closing)[2..], ["00E#88000000", "00B#AC003D00", "00B#88000400"]);
    // F2 to 195569 counts, F3 in torque mode with 0.701 / 125 * 20000 units.
    begin(&mut driver, 14);
    assert_eq!(
        command(&mut driver, &closing)[2..],
        ["00C#B400F1FB0200", "00C#88000500", "00D#88000200", "00D#AA007000"]
    );
    begin(&mut driver, 16);
    assert_eq!(command(&mut driver, &closing).len(), 2, "nothing new");
    // A finger that touches is stopped at once, before others are set going.
    let felt = commands([
        HandCommand::Velocity(0.5),
        HandCommand::Idle,
        HandCommand::Velocity(0.0),
        HandCommand::Velocity(0.75),
    ]);
    begin(&mut driver, 18);
    assert_eq!(command(&mut driver, &felt)[2..], ["00C#88000000", "00D#AC000000", "00D#88000400"]);
    begin(&mut driver, 20);
    assert_eq!(command(&mut driver, &felt)[2..], ["00B#AC002800", "00B#88000400", "00E#AC000800", "00E#88000400"]);
}

#[test]
fn a_hand_value_that_is_not_a_number_makes_idle_and_a_torque_none() {
    let mut driver = running();
    begin(&mut driver, 12);
    let hand = [
        HandCommand::Position(f32::NAN),
        HandCommand::Velocity(f32::INFINITY),
        HandCommand::Torque(f32::NAN),
        HandCommand::Idle,
    ];
    let commands = JointCommands { tick: 12, arm_tau_nm: [f32::NAN; 7], hand };
    assert_eq!(
        command(&mut driver, &commands),
        ["401#AA00000000000000", "402#AA00000000000000", "00B#88000000", "00C#88000000"]
    );
}

#[test]
fn pads_are_asked_for_in_turn_and_come_out_once_whole_with_the_tick_they_were_asked_at() {
    let mut driver = PuckDriver::new(Calibration::default());
    let idle = JointCommands::idle(0);
    let mut asked = Vec::new();
    for tick in 0..40 {
        begin(&mut driver, tick);
        asked.extend(command(&mut driver, &idle).into_iter().skip(2).filter(|f| f.contains("#EA")).map(|f| (tick, f)));
    }
    let expected = [
        (5, "00B"),
        (9, "00C"),
        (13, "00D"),
        (17, "00E"),
        (21, "00B"),
        (25, "00C"),
        (29, "00D"),
        (33, "00E"),
        (37, "00B"),
    ];
    // At tick 1 the hand's first orders had priority.
    assert_eq!(asked, expected.map(|(tick, id)| (tick, std::format!("{id}#EA000200"))));
    let image: [u16; PAD_CELLS] = core::array::from_fn(|n| 170 * n as u16);
    let frames = FullFrame::of_image(&image).map(|frame| report(Node::HAND[3], Feedback::TactileFull(frame)));
    for n in [4, 2, 0, 1] {
        assert!(driver.receive(&frames[n]));
        assert_eq!(driver.take_images(), [None; PADS]);
    }
    driver.receive(&frames[3]);
    let [None, None, None, Some(palm)] = driver.take_images() else { panic!("one image") };
    assert_eq!((palm.pad, palm.stamp), (3, 33));
    assert!((0..PAD_CELLS).all(|n| palm.pressure_n_cm2[n] == 170.0 * n as f32 / 256.0));
    assert_eq!(driver.take_images(), [None; PADS], "once");
}

#[test]
fn an_image_with_a_frame_missing_is_not_mixed_with_the_next() {
    let mut driver = PuckDriver::new(Calibration::default());
    let idle = JointCommands::idle(0);
    let frames =
        |value| FullFrame::of_image(&[value; PAD_CELLS]).map(|f| report(Node::HAND[0], Feedback::TactileFull(f)));
    for tick in 0..40 {
        begin(&mut driver, tick);
        command(&mut driver, &idle);
        if tick == 5 {
            frames(1)[..4].iter().for_each(|f| assert!(driver.receive(f)));
        }
        if tick == 21 {
            frames(2)[4..].iter().for_each(|f| assert!(driver.receive(f)));
        }
        assert_eq!(driver.take_images(), [None; PADS], "tick {tick}");
    }
    assert_eq!(driver.stats().torn_images, 2);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn whatever_is_on_the_wire_readings_are_finite_and_no_bit_is_set_without_an_answer(
        frames in prop::collection::vec((0..0x800_u16, prop::collection::vec(any::<u8>(), 0..=8), any::<bool>()), 0..200),
        torques in prop::array::uniform7(prop::num::f32::ANY),
        values in prop::array::uniform4((0..4_u8, prop::num::f32::ANY)),
    ) {
        let mut driver = PuckDriver::new(Calibration::default());
        let mut startup = Startup::default();
        startup.tick(&mut |_| ());
        for (n, (id, data, puck)) in frames.iter().enumerate() {
            if n % 20 == 0 {
                driver.begin(n as u32 / 20, &mut |_| ());
            }
            // Half of them under identifiers that pucks use.
            let id = if *puck { 0x400 | id & 0x1e0 | [3, 6, 7, 9][usize::from(id & 3)] } else { *id };
            let frame = CanFrame::new_base(id, data, Mtu::Classic).expect("fits");
            driver.receive(&frame);
            startup.receive(&frame, &mut |_| ());
            if let Some(readings) = driver.readings() {
                prop_assert!(readings.is_finite());
                prop_assert_eq!(readings.valid.0 & EFFORTS, 0);
                for m in 0..4 {
                    prop_assert!(readings.valid.0 >> (7 + m) & 1 == 0 || driver.motors[m].is_some());
                }
            }
            prop_assert!(driver.take_images().iter().flatten().all(|i| i.pressure_n_cm2.iter().all(|p| (0.0..16.0).contains(p))));
        }
        let hand = values.map(|(mode, value)| match mode {
            0 => HandCommand::Idle,
            1 => HandCommand::Position(value),
            2 => HandCommand::Velocity(value),
            _ => HandCommand::Torque(value),
        });
        for _ in 0..3 {
            driver.command(&JointCommands { tick: 0, arm_tau_nm: torques, hand }, &mut |frame| {
                assert!(Message::parse(&frame).is_ok());
            });
        }
    }

    #[test]
    fn a_joint_angle_is_read_within_a_count_of_the_motors(q in prop::array::uniform7(-1.0..1.0_f32)) {
        let mut driver = PuckDriver::new(Calibration::default());
        driver.begin(0, &mut |_| ());
        for (node, motor_rad) in Node::ARM.iter().zip(units::motors_from_joints(&q)) {
            driver.receive(&position(*node, units::arm_counts(motor_rad).get(), None));
        }
        let readings = driver.readings().expect("answered");
        for (read, q) in readings.arm_q_rad.iter().zip(q) {
            // One count is 2 pi / 4096 of a motor turn; two motors of 9.7 : 1 move a wrist joint.
            prop_assert!((read - q).abs() < 4.0 * FRAC_PI_2 / 4096.0 / 9.0, "{read} {q}");
        }
    }
}
