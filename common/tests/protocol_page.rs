//! `docs/protocol.md` says what the code does: its table of messages is compared with the messages' own schema, and
//! the schema with encoded messages.

use postcard_schema::schema::{DataModelType as Type, DataModelVariant as Variant, NamedType};
use tactus_common::limits::{KNOTS_MAX, OBSTACLES_MAX, PAYLOAD_BYTES_MAX};
use tactus_common::link::{SETUP_BYTES, SMALL_BYTES, encode};
use tactus_common::message::{
    Command, Event, EventKind, MESSAGES, Message, Phase, PlanAnswer, RefusalReason, RolloutResult, SCHEMA_VERSION,
    SensorFrame, Setup,
};
use tactus_common::method::Method;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{JointCommands, JointReadings, Validity};
use tactus_common::shape::hull::{HULL_CORNERS_MAX, HULL_FACE_BYTES_MAX, HULL_FACES_MAX};
use tactus_common::shape::{Hull, ObjectShape, Obstacle};
use tactus_common::trajectory::{Knot, Trajectory};

const PAGE: &str = include_str!("../../docs/protocol.md");

/// Fewest and most bytes that postcard needs for a type (its wire format: fixed floats and bytes, other integers in
/// groups of seven bits, one byte for what there is of an option, the number of a variant as an integer).
fn bytes(of: &NamedType) -> [usize; 2] {
    let integer = |bits: usize| [1, bits.div_ceil(7)];
    match of.ty {
        Type::Bool | Type::U8 | Type::I8 => [1, 1],
        Type::U16 | Type::I16 => integer(16),
        Type::U32 | Type::I32 => integer(32),
        Type::U64 | Type::I64 => integer(64),
        Type::F32 => [4, 4],
        Type::Unit | Type::UnitStruct => [0, 0],
        Type::NewtypeStruct(inner) => bytes(inner),
        Type::Option(inner) => [1, 1 + bytes(inner)[1]],
        // The lists on the wire: the knots of a trajectory, the corners and the faces of a hull. Their lengths take one byte.
        Type::Seq(inner) => {
            let most = match inner.ty {
                Type::Struct(_) => KNOTS_MAX,
                Type::Tuple(_) => HULL_CORNERS_MAX,
                _ => HULL_FACE_BYTES_MAX,
            };
            assert!(most < 128, "{}: the length of a list takes one byte", of.name);
            [1, 1 + most * bytes(inner)[1]]
        }
        Type::Tuple(parts) | Type::TupleStruct(parts) => sum(parts.iter().map(|t| bytes(t))),
        Type::Struct(fields) => sum(fields.iter().map(|f| bytes(f.ty))),
        Type::Enum(variants) => {
            let of_variant = |v: &Variant| match v {
                Variant::UnitVariant => [0, 0],
                Variant::NewtypeVariant(inner) => bytes(inner),
                Variant::TupleVariant(parts) => sum(parts.iter().map(|t| bytes(t))),
                Variant::StructVariant(fields) => sum(fields.iter().map(|f| bytes(f.ty))),
            };
            let sizes = || variants.iter().map(|v| of_variant(v.ty));
            let least = sizes().map(|s| s[0]).min().unwrap_or(0);
            let most = sizes().map(|s| s[1]).max().unwrap_or(0);
            assert!(variants.len() < 128, "the number of a variant takes one byte");
            [1 + least, 1 + most]
        }
        other => panic!("{}: no message holds {other:?} so far", of.name),
    }
}

fn sum(parts: impl Iterator<Item = [usize; 2]>) -> [usize; 2] {
    parts.fold([0, 0], |a, b| [a[0] + b[0], a[1] + b[1]])
}

fn encoded<M: Message>(message: &M) -> usize {
    let mut buffer = [0; PAYLOAD_BYTES_MAX];
    encode(message, &mut buffer).expect("every message fits the largest payload").len()
}

/// As many corners and edges as a hull may have: a prism over twelve corners, eight of its sides cut in two.
fn largest_hull() -> Hull {
    let corner = |i: u8| {
        let (s, c) = libm::sincosf(f32::from(i % 12) * std::f32::consts::FRAC_PI_6);
        [0.1 * c, 0.1 * s, if i < 12 { -0.1 } else { 0.1 }]
    };
    let mut faces: Vec<Vec<u8>> = vec![(0..12).rev().collect(), (12..24).collect()];
    for i in 0..12 {
        let next = (i + 1) % 12;
        match i {
            0..8 => faces.extend([vec![i, next, next + 12], vec![i, next + 12, i + 12]]),
            _ => faces.push(vec![i, next, next + 12, i + 12]),
        }
    }
    let corners_m: Vec<_> = (0..24).map(corner).collect();
    Hull::new(&corners_m, faces.iter().map(Vec::as_slice)).expect("a closed convex polyhedron")
}

fn bytes_of(name: &str) -> [usize; 2] {
    bytes(MESSAGES.iter().find(|m| m.name == name).expect("listed").schema)
}

/// The cells of the rows of the page whose first cell is a message's name in backticks.
fn rows() -> Vec<Vec<&'static str>> {
    let cells = |line: &'static str| line.split('|').skip(1).map(str::trim).collect::<Vec<_>>();
    let is_message = |first: &&str| MESSAGES.iter().any(|m| *first == format!("`{}`", m.name));
    PAGE.lines().map(cells).filter(|cells| cells.first().is_some_and(is_message)).collect()
}

#[test]
fn the_page_lists_every_message_with_its_subject_priority_and_bytes() {
    let rows = rows();
    for message in MESSAGES {
        let [least, most] = bytes(message.schema);
        let size = if least == most { format!("{most}") } else { format!("{least}-{most}") };
        let expected = [format!("`{}`", message.name), message.subject.to_string(), message.priority.to_string(), size];
        let row: Vec<_> = rows.iter().filter(|cells| cells[0] == expected[0]).collect();
        assert_eq!(row.len(), 1, "one row for {}", message.name);
        assert_eq!(row[0][..4], expected, "docs/protocol.md");
    }
    assert_eq!(rows.len(), MESSAGES.len());
}

#[test]
fn subjects_are_unique_and_of_thirteen_bits() {
    for (i, message) in MESSAGES.iter().enumerate() {
        assert!(message.subject < 1 << 13 && message.priority < 8, "{}", message.name);
        assert!(MESSAGES.iter().skip(i + 1).all(|other| other.subject != message.subject), "{}", message.name);
    }
}

#[test]
fn a_message_fits_the_small_buffer_and_the_set_up_and_the_trajectory_their_own() {
    for message in MESSAGES {
        let limit = match message.name {
            "PlanAnswer" => PAYLOAD_BYTES_MAX,
            "Setup" => SETUP_BYTES,
            _ => SMALL_BYTES,
        };
        assert!(bytes(message.schema)[1] <= limit, "{}", message.name);
    }
}

#[test]
fn encoded_messages_reach_the_bounds_that_the_schema_gives() {
    let hull = ObjectShape::Convex(largest_hull());
    let setup = Setup {
        schema_version: SCHEMA_VERSION.to_le_bytes(),
        shape: hull,
        guess: PlanarPose::default(),
        interval: Interval::default(),
        obstacles: [Some(Obstacle { shape: hull, pose: PlanarPose::default() }); OBSTACLES_MAX],
        displacement_m: [0.0; 2],
        mass_kg: 0.6,
        trials_max: 255,
        robot_base: tactus_common::robot::MOUNT,
        method: Method { evaluations_max: u16::MAX, ..Method::DEFAULT },
    };
    let sphere = ObjectShape::Sphere { radius_m: 0.05 };
    let least = Setup { shape: sphere, obstacles: [None; OBSTACLES_MAX], method: Method::DEFAULT, ..setup };
    // A hull of 44 edges has two faces less than one may have, and each face tells one byte more than its corners.
    let unused = (1 + OBSTACLES_MAX) * (HULL_FACES_MAX - 22);
    // And without any corner it would be shorter than a sphere, if it were one.
    assert_eq!([encoded(&least) - 2, encoded(&setup) + unused], bytes_of("Setup"));
    let readings = JointReadings {
        tick: u32::MAX,
        arm_q_rad: [9.0; 7],
        motor_q_rad: [9.0; 4],
        inner_q_rad: [9.0; 3],
        effort_nm: [99.0; 4],
        tip_torque_nm: [99.0; 3],
        valid: Validity::ALL,
    };
    assert_eq!([encoded(&SensorFrame::pack(&readings)); 2], bytes_of("SensorFrame"));
    assert_eq!([encoded(&Command::pack(&JointCommands::idle(0))); 2], bytes_of("Command"));

    let refusal = PlanAnswer { effective: 0, request: 0, result: Err(RefusalReason::NoPath) };
    assert_eq!(encoded(&refusal), bytes_of("PlanAnswer")[0]);
    let knots = core::iter::repeat_n(Knot::default(), KNOTS_MAX).collect();
    let full = Trajectory { request: u16::MAX, knots, guarded_from: 255 };
    let answer = PlanAnswer { effective: u32::MAX, request: u16::MAX, result: Ok(full) };
    assert_eq!(encoded(&answer), bytes_of("PlanAnswer")[1]);

    let nothing = RolloutResult { effective: 0, request: 0, onset_inner_rad: [None; 3], contacts: [0; 16] };
    let all = RolloutResult {
        effective: u32::MAX,
        request: u16::MAX,
        onset_inner_rad: [Some(1.0); 3],
        contacts: [u16::MAX; 16],
    };
    assert_eq!([encoded(&nothing), encoded(&all)], bytes_of("RolloutResult"));

    let updated = EventKind::Updated {
        belief: PlanarPose::default(),
        covariance: [0.0; 6],
        evaluations: u16::MAX,
        modes: 255,
        confident: true,
    };
    assert_eq!(encoded(&Event { tick: u32::MAX, kind: updated }), bytes_of("Event")[1]);
    assert_eq!(encoded(&Event { tick: 0, kind: EventKind::Phase(Phase::Done) }), bytes_of("Event")[0]);
}
