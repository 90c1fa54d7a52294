//! Every example and test vector that the project's facts give for this protocol, frames as candump writes them.

extern crate std;

use super::super::force::{self, Triple};
use super::super::packed::{Counts, Position, Torques};
use super::super::property::{force as ft, motor, safety};
use super::super::state::{Button, HandOrder, Light, Mode, Pendant, Role, SafetyMode, Status};
use super::super::tactile::{self, FullFrame, Top10};
use super::super::*;
use crate::can::{CanFrame, Mtu};
use crate::limits::PAD_CELLS;
use crate::robot::arm;
use crate::robot::tables::{GEAR_INNER, GEAR_SECONDARY, GEAR_SPREAD, HAND_MOTOR_COUNTS, SECONDARY_COUNTS};
use core::f32::consts::PI;
use nalgebra::{Isometry3, Vector3};
use std::vec::Vec;

/// `00B#9D000D000000`.
fn frame(text: &str) -> CanFrame {
    let (id, data) = text.split_once('#').unwrap();
    let data: Vec<u8> = (0..data.len()).step_by(2).map(|n| u8::from_str_radix(&data[n..n + 2], 16).unwrap()).collect();
    CanFrame::new_base(u16::from_str_radix(id, 16).unwrap(), &data, Mtu::Classic).unwrap()
}

/// The frame is read as this, and this is sent as the frame.
fn command(text: &str, expected: Command) {
    assert_eq!(Message::parse(&frame(text)), Ok(Message::Command(expected)), "{text}");
    assert_eq!(expected.frame(), frame(text));
}

fn report(text: &str, from: Node, expected: Feedback) {
    let expected = Report::new(from, expected).unwrap();
    assert_eq!(Message::parse(&frame(text)), Ok(Message::Report(expected)), "{text}");
    assert_eq!(expected.frame(), frame(text));
}

fn value(text: &str) -> i32 {
    match Message::parse(&frame(text)) {
        Ok(Message::Report(report)) => match report.feedback() {
            Feedback::Value(_, value) => value.get(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

const F1: Node = Node::HAND[0];

#[test]
fn get_of_the_status_of_puck_11_is_answered_ready() {
    command("00B#05", Command::get(F1, motor::STAT));
    report("566#85000200", F1, Feedback::Value(motor::STAT, Value::Short(2)));
    assert_eq!(Status::from_number(value("566#85000200")), Some(Status::Ready));
}

#[test]
fn get_of_the_counts_per_turn_is_answered_with_32_bits() {
    command("00B#44", Command::get(F1, motor::CTS));
    report("566#C40000100000", F1, Feedback::Value(motor::CTS, Value::Long(4096)));
}

#[test]
fn the_hand_is_initialised_by_cmd_13() {
    command("00B#9D000D000000", Command::set_long(F1, motor::CMD, HandOrder::Initialise.number().into()));
}

#[test]
fn a_get_to_the_hand_is_answered_by_each_puck_under_its_own_identifier() {
    command("405#4D", Command::get(Group::HAND, motor::HOLD));
    for (id, node) in ["566", "586", "5A6", "5C6"].iter().zip(Node::HAND) {
        report(&std::format!("{id}#CD000100"), node, Feedback::Value(motor::HOLD, Value::Short(1)));
    }
}

#[test]
fn the_pendant_at_rest_is_all_green_with_the_idle_lamp_and_shows_zero() {
    command("00A#2B", Command::get(Node::SAFETY, safety::PEN));
    let text = "546#AB0049123F0D";
    report(text, Node::SAFETY, Feedback::Value(safety::PEN, Value::Long(0x0d3f_1249)));
    let expected = Pendant {
        button: Button::None,
        activate_lamp: false,
        idle_lamp: true,
        segments: 0x3f,
        lights: [Light::Green; 5],
    };
    assert_eq!(Pendant::parse(value(text) as u32), Some(expected));
    assert_eq!(Pendant::parse(0x0d3f_1248), None, "a light without colour");
    assert_eq!(Pendant::parse(0x0d3f_124b), None, "a light with two");
    assert_eq!(
        Pendant::parse(0x013f_1289).map(|p| (p.button, p.lights[2])),
        Some((Button::EmergencyStop, Light::Yellow))
    );
}

#[test]
fn the_safety_modules_own_broadcast_is_a_mode_for_all_pucks() {
    for (text, mode) in [("540#88000200", Mode::Torque), ("540#88000000", Mode::Idle)] {
        let Ok(Message::Command(command)) = Message::parse(&frame(text)) else { panic!("{text}") };
        assert_eq!(command.address(), Address { from: Node::SAFETY, to: Group::ALL_PUCKS.into() });
        assert_eq!(command.order(), Order::Set(motor::MODE, Value::Short(mode.number())));
        assert_eq!(command.frame(), frame(text));
    }
}

#[test]
fn positions_have_22_bits_and_the_upper_two_of_each_byte_0_say_nothing() {
    let packed = |counts: i32| Counts::new(counts).unwrap().pack();
    assert_eq!(packed(-36_833), [0xbf, 0x70, 0x1f]);
    assert_eq!(packed(36_832), [0x80, 0x8f, 0xe0]);
    assert_eq!(packed(0), [0x80, 0x00, 0x00]);
    for top in [0x00, 0x40, 0x80, 0xc0] {
        assert_eq!(Counts::unpack([top | 0x3f, 0x70, 0x1f]).get(), -36_833);
        assert_eq!(Counts::unpack([top, 0x8f, 0xe0]).get(), 36_832);
    }
    assert_eq!([Counts::MIN, Counts::MAX].map(Counts::get), [-2_097_152, 2_097_151]);
    assert_eq!([-2_097_153, 2_097_152].map(Counts::new), [None; 2]);
    let both = Position { primary: Counts::new(195_000).unwrap(), secondary: Counts::new(78_000) };
    report("563#82F9B88130B0", F1, Feedback::Position(both));
    for text in ["563#82F9B881", "563#", "563#82F9B88130B000"] {
        assert_eq!(Message::parse(&frame(text)), Err(ParseError::Length), "{text}");
    }
}

#[test]
fn home_in_counts_and_its_frames() {
    let home_rad = [0.0, -2.0, 0.0, 3.13, 0.0, 0.0, 0.0];
    let counts = units::motors_from_joints(&home_rad).map(units::arm_counts);
    assert_eq!(counts.map(Counts::get), [0, -36_833, 36_832, -36_728, 0, 0, 0]);
    let frames = ["002#B0001F70FFFF", "003#B000E08F0000", "004#B0008870FFFF"];
    let replies = ["443#BF701F", "463#808FE0", "483#BF7088"];
    for n in 0..3 {
        let (node, primary) = (Node::ARM[n + 1], counts[n + 1]);
        command(frames[n], Command::set_long(node, motor::P, primary.get()));
        report(replies[n], node, Feedback::Position(Position { primary, secondary: None }));
    }
    // Back within a count of each motor.
    let back_rad = units::joints_from_motors(&counts.map(units::arm_motor_rad));
    assert!(back_rad.iter().zip(home_rad).all(|(a, b)| (a - b).abs() < 1e-4), "{back_rad:?}");
}

#[test]
fn gravity_torques_at_home_in_puck_units_and_their_frames() {
    // J1 as libbarrett computed it: nothing, but for the last bit of a double.
    let tau_nm = [8.4e-14, 16.0262, -0.4130, -4.3880, -0.0539, -0.2261, -0.0007];
    let ipnm = [2700.0, 2562.0, 2562.0, 2700.0, 6500.0, 6500.0, 17474.0];
    let motor_nm = units::motor_torques(&tau_nm);
    let sent: [i32; 7] = core::array::from_fn(|m| units::torque_units(motor_nm[m], ipnm[m]));
    assert_eq!(sent, [-1, 758, -696, 658, 57, -94, 0]);
    let [a, b, c, d, e, f, g] = sent;
    command("401#AAFFFC2F6F520292", Command::torques(Group::LOWER_ARM, Torques::clamped([a, b, c, d])));
    command("402#AA00E7FA20000000", Command::torques(Group::WRIST, Torques::clamped([e, f, g, 0])));
}

#[test]
fn packed_torques_are_one_number_of_56_bits() {
    let slots = [-8191, 8191, -1, 1];
    let bits = slots.iter().fold(0_u64, |bits, slot| bits << 14 | (*slot as u64 & 0x3fff));
    assert_eq!(Torques::clamped(slots).pack(), bits.to_be_bytes()[1..]);
    assert_eq!(Torques::clamped([i32::MIN, i32::MAX, -8192, 8192]).slots(), [-8191, 8191, -8191, 8191]);
}

#[test]
fn transmissions_are_the_published_ones_both_ways() {
    let j = &units::JOINT_FROM_MOTOR;
    let near = |a: f32, b: f32| (a - b).abs() < 1e-7;
    assert!(near(j[0][0], -0.023_809_5));
    assert!(near(j[1][1], 0.017_699_1) && near(j[1][2], -0.017_699_1));
    assert!(near(j[2][1], -0.029_734_5) && near(j[2][2], -0.029_734_5));
    assert!(near(j[3][3], -0.055_555_6));
    assert!(near(j[4][4], 0.051_546_4) && near(j[4][5], 0.051_546_4));
    assert!(near(j[5][4], -0.051_546_4) && near(j[5][5], 0.051_546_4));
    assert!(near(j[6][6], -0.066_979_2));
    let others = j.iter().flatten().filter(|value| value.abs() > 1e-12).count();
    assert_eq!(others, 11, "and nothing else");
}

#[test]
fn counts_of_the_hand() {
    let per_rad = |gear: f32| HAND_MOTOR_COUNTS as f32 * gear / (2.0 * PI);
    assert!((per_rad(GEAR_INNER) - 81_487.33).abs() < 0.01 && (per_rad(GEAR_SPREAD) - 11_408.23).abs() < 0.01);
    assert!((SECONDARY_COUNTS as f32 * GEAR_SECONDARY / (2.0 * PI) - 32_594.93).abs() < 0.01);
    assert_eq!(units::hand_counts(2.4, GEAR_INNER), 195_569);
    assert_eq!(195_569, 0x2fbf1);
    assert_eq!(units::hand_counts(PI, GEAR_SPREAD), 35_840);
    assert_eq!([GEAR_INNER, GEAR_SPREAD].map(|gear| units::hand_counts_per_ms(0.75, gear)), [61, 8]);
    // Before breakaway the secondary encoder shows 0.4 of the primary one, and both say the same angle.
    let angle = |counts, per_turn, gear| units::hand_joint_rad(Counts::new(counts).unwrap(), per_turn, gear);
    let (motor, worm) =
        (angle(195_000, HAND_MOTOR_COUNTS, GEAR_INNER), angle(78_000, SECONDARY_COUNTS, GEAR_SECONDARY));
    assert!((motor - 2.393).abs() < 5e-4 && (motor - worm).abs() < 1e-6, "{motor} {worm}");
}

#[test]
fn a_whole_tactile_image_with_cells_of_32_n() {
    let image: [u16; PAD_CELLS] = core::array::from_fn(|n| 32 * n as u16);
    let frames = FullFrame::of_image(&image);
    report("569#0000020040060080", F1, Feedback::TactileFull(frames[0]));
    // The last place of the last frame is unused; the sender of this example filled it with what it had.
    assert_eq!(frames[4].pack()[..6], [0x42, 0x80, 0x2a, 0x02, 0xc0, 0x2e]);
    let Ok(Message::Report(last)) = Message::parse(&frame("569#42802A02C02E0300")) else { panic!("no report") };
    let Feedback::TactileFull(last) = last.feedback() else { panic!("{last:?}") };
    assert_eq!((last.index(), &last.cells()[..4]), (4, &image[20..]));
    let mut pad = tactile::FullImage::default();
    assert_eq!(frames[..4].iter().find_map(|frame| pad.add(frame)), None);
    assert_eq!(pad.add(&last), Some(image));
    assert_eq!(Message::parse(&frame("569#5000020040060080")), Err(ParseError::FrameIndex(5)));
    assert_eq!(Message::parse(&frame("569#00000200400600")), Err(ParseError::Length));
    assert_eq!(f32::from(tactile::CELL_MAX) / tactile::UNITS_PER_N_CM2, 15.996_094);
}

#[test]
fn ten_cells_are_named_by_a_map_with_ten_bits() {
    let top = Top10::new(0xffc000, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]).unwrap();
    report("568#FFC000123456789A", F1, Feedback::TactileTop(top));
    let mut first_ten = [0; PAD_CELLS];
    (0..10).for_each(|n| first_ten[n] = n as u8 + 1);
    assert_eq!(top.cells_n_cm2(tactile::MapOrder::HighestFirst), first_ten);
    assert_eq!(top.cells_n_cm2(tactile::MapOrder::LowestFirst)[14..], first_ten[..10]);
    for (text, map) in [("568#FF8000123456789A", 0xff8000), ("568#FFE000123456789A", 0xffe000)] {
        assert_eq!(Message::parse(&frame(text)), Err(ParseError::Map(map)));
    }
}

#[test]
fn forces_of_256_are_newtons_and_torques_of_4096_newton_metres() {
    let force_raw = Triple { xyz: [256, -512, 768], flags: None };
    assert_eq!(force_raw.scaled(force::UNITS_PER_N), [1.0, -2.0, 3.0]);
    report("50A#000100FE0003", Node::FORCE, Feedback::Force(force_raw));
    let torque_raw = Triple { xyz: [4096, -2048, 1024], flags: None };
    assert_eq!(torque_raw.scaled(force::UNITS_PER_NM), [1.0, -0.5, 0.25]);
    report("50B#001000F80004", Node::FORCE, Feedback::Torque(torque_raw));
    report("50B#001000F8000441", Node::FORCE, Feedback::Torque(Triple { flags: Some(0x41), ..torque_raw }));
    report("50C#001000F80004", Node::FORCE, Feedback::Acceleration(torque_raw));
    assert_eq!(Message::parse(&frame("50A#000100FE00")), Err(ParseError::Length));
    command("008#36", Command::get(Node::FORCE, ft::FT));
    command("008#40", Command::get(Node::FORCE, ft::A));
}

#[test]
fn values_may_be_short_or_long_for_any_property_but_nothing_else() {
    let set = |text| match Message::parse(&frame(text)) {
        Ok(Message::Command(command)) => Ok(command.order()),
        Ok(other) => panic!("{other:?}"),
        Err(error) => Err(error),
    };
    assert_eq!(set("00B#8800FFFF"), Ok(Order::Set(motor::MODE, Value::Short(-1))));
    assert_eq!(set("00B#8800FFFFFFFF"), Ok(Order::Set(motor::MODE, Value::Long(-1))));
    assert_eq!(set("00B#B800B8F90200"), Ok(Order::Set(motor::CT, Value::Long(195_000))), "needs the 32 bits");
    assert_eq!(set("00B#88010200"), Err(ParseError::Malformed), "second byte");
    assert_eq!(set("00B#08000200"), Err(ParseError::Malformed), "no mark");
    assert_eq!(set("00B#85"), Err(ParseError::Malformed), "a mark without value");
    assert_eq!(set("00B#880002"), Err(ParseError::Length));
    assert_eq!(set("00B#8800020000000000"), Err(ParseError::Length), "eight bytes are torques alone");
    assert_eq!(set("00B#"), Err(ParseError::Length));
}

#[test]
fn enumerations_are_the_published_numbers() {
    assert_eq!(Status::ALL.iter().map(|s| s.number()).collect::<Vec<_>>(), [0, 1, 2]);
    let modes = [Mode::Idle, Mode::Duty, Mode::Torque, Mode::Position, Mode::Velocity, Mode::Trapezoidal];
    assert_eq!(modes.map(Mode::number), [0, 1, 2, 3, 4, 5]);
    assert_eq!(
        [0, 1, 2, 3].map(SafetyMode::from_number),
        [Some(SafetyMode::EmergencyStop), Some(SafetyMode::Idle), Some(SafetyMode::Active), None]
    );
    assert_eq!([HandOrder::Initialise, HandOrder::Close, HandOrder::Open].map(HandOrder::number), [13, 18, 20]);
    assert_eq!(Mode::from_number(6), None);
    for mode in Mode::ALL {
        assert_eq!(Mode::from_number(mode.number().into()), Some(*mode));
    }
    let finger = Role(0x1805);
    assert_eq!(finger.kind(), Role::HAND_MOTOR);
    assert!(finger.has(Role::STRAIN_GAUGE) && finger.has(Role::TACTILE) && !finger.has(Role::JOINT_ENCODER));
    let spread = Role(0x1005);
    assert!(!spread.has(Role::STRAIN_GAUGE) && spread.has(Role::TACTILE));
    assert_eq!((Role(0x0100).kind(), Role(2).kind(), Role(6).kind()), (Role::ARM_MOTOR, Role::SAFETY, Role::FORCE));
}

/// Number of a property in a column of the table of all firmware versions.
fn listed(column: &str, name: &str) -> Option<u8> {
    let mut lines = include_str!("properties.csv").lines();
    let place = lines.next()?.split(',').position(|title| title == column)?;
    let row = lines.find(|line| line.split(',').next() == Some(name))?;
    row.split(',').nth(place)?.parse().ok()
}

#[test]
fn property_numbers_are_those_of_every_supported_firmware() {
    for (name, property) in motor::ALL {
        let newest = listed("motor_ge175", name);
        assert_eq!(newest, Some(property.number()), "{name}");
        // The force sensor's and the safety module's first 42 are the same.
        if property.number() < 42 {
            assert_eq!(listed("forcetorque", name), newest, "{name}");
        }
        for older in ["motor_ge145", "motor_ge168"] {
            let moved = *name == "IHIT";
            assert_eq!(listed(older, name), if moved { None } else { newest }, "{name} in {older}");
        }
    }
    for (name, property) in safety::ALL {
        assert_eq!(listed("safety_ge61", name), Some(property.number()), "{name}");
    }
    for (name, property) in ft::ALL {
        assert_eq!(listed("forcetorque", name), Some(property.number()), "{name}");
    }
    assert_eq!((listed("motor_ge145", "TACTID"), listed("motor_ge142", "TACTID")), (Some(107), None));
    for name in ["VERS", "ROLE", "SN", "ID", "ERROR", "STAT", "ADDR", "VALUE"] {
        assert_eq!(listed("unknown", name), motor::ALL.iter().find(|(n, _)| *n == name).map(|(_, p)| p.number()));
    }
}

#[test]
fn a_property_of_32_bits_is_one_whose_next_number_means_nothing() {
    let taken = |number: u8| motor::ALL.iter().any(|(_, property)| property.number() == number);
    for (name, property) in motor::ALL {
        let last = property.number() == 108;
        let expected = !taken(property.number() + 1) && !last;
        assert_eq!(property.is_long_on_motor(), expected, "{name}");
    }
}

/// The frame of Barrett's tool plate (0.0609 m beyond the wrist) in that of the shoulder.
fn tool(q_rad: [f32; 7]) -> Isometry3<f32> {
    let wrist = arm::link_poses_from(&Isometry3::translation(0.0, 0.0, -0.346), &q_rad)[6];
    wrist * Isometry3::translation(0.0, 0.0, 0.0609)
}

#[test]
fn joint_angles_mean_what_they_mean_to_barretts_library() {
    let cases = [
        ([0.0, -2.0, 0.0, 3.13, 0.0, 0.0, 0.0], [-0.21164, 0.0, 0.00672]),
        ([0.0; 7], [0.0, 0.0, 0.9109]),
        ([0.5, -1.0, 0.3, 1.5, -0.4, 0.6, 0.2], [-0.30378, -0.04804, 0.63735]),
    ];
    for (q_rad, expected) in cases {
        let found = tool(q_rad).translation.vector;
        assert!((found - Vector3::from(expected)).norm() < 2e-5, "{q_rad:?}: {found}");
    }
    let turn = tool(cases[0].0).rotation.to_rotation_matrix();
    let expected = [[0.42666, 0.0, 0.90441], [0.0, 1.0, 0.0], [-0.90441, 0.0, 0.42666]];
    for (i, row) in expected.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            assert!((turn[(i, j)] - value).abs() < 2e-5, "{i} {j}: {turn}");
        }
    }
}

/// Torques that hold the arm of Barrett's example configuration: link k pulls with its mass times the way to its centre
/// of mass, `mu` (kg m), given in its frame of the Denavit-Hartenberg convention, which is ours turned about x.
fn gravity_by_mu(q_rad: [f32; 7]) -> [f32; 7] {
    const MU_KG_M: [[f32; 3]; 7] = [
        [-0.461_981_33, 0.0, -0.000_165_071_28],
        [0.093_246_83, -0.142_991_58, 2.382_762_2],
        [0.091_026_04, 0.177_400_08, 0.109_418],
        [-0.126_385_76, -0.057_018_97, 0.541_528_1],
        [0.002_226_522_4, 0.013_625_292, -0.001_011_957],
        [-0.000_899_807_3, -0.004_992_465_3, 0.025_922_7],
        [-0.000_039_600_33, -0.000_075_432_36, 0.000_013_030_526],
    ];
    const ALPHA: [f32; 7] = [-0.5, 0.5, -0.5, 0.5, -0.5, 0.5, 0.0];
    let gravity = Vector3::new(0.0, 0.0, -9.805);
    let poses = arm::link_poses_from(&Isometry3::identity(), &q_rad);
    let moments: Vec<Vector3<f32>> = (0..7)
        .map(|k| {
            let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), ALPHA[k] * PI);
            gravity.cross(&(poses[k].rotation * turn * Vector3::from(MU_KG_M[k])))
        })
        .collect();
    core::array::from_fn(|j| (poses[j].rotation * Vector3::z()).dot(&moments[j..].iter().sum()))
}

#[test]
fn joint_torques_mean_what_they_mean_to_barretts_library() {
    let home = [0.0, -2.0, 0.0, 3.13, 0.0, 0.0, 0.0];
    let stretched = [0.0, PI / 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let cases = [
        (home, [0.0, 16.0262, -0.4130, -4.3880, -0.0539, -0.2261, -0.0007], 1e-4),
        (stretched, [0.0, -27.054, 0.454, -5.430, -0.060, -0.254, -0.001], 1e-3),
    ];
    for (q_rad, expected_nm, tolerance) in cases {
        let found_nm = gravity_by_mu(q_rad);
        let near = found_nm.iter().zip(expected_nm).all(|(a, b)| (a - b).abs() < tolerance);
        assert!(near, "{found_nm:?}");
    }
}
