//! What is sent is what is read, and whatever is read does no harm.

extern crate std;

use super::super::force::Triple;
use super::super::packed::{TORQUE_MAX, Torques};
use super::super::tactile::{CELL_MAX, FULL_FRAMES, FullFrame, FullImage, MapOrder, Top10};
use super::super::*;
use crate::can::{BASE_ID_MAX, CanFrame, ID_MAX, Mtu};
use crate::limits::PAD_CELLS;
use proptest::prelude::*;

fn node() -> impl Strategy<Value = Node> {
    (0..32_u8).prop_map(|n| Node::new(n).unwrap())
}

fn destination() -> impl Strategy<Value = Destination> {
    (0..32_u8, any::<bool>()).prop_map(
        |(n, group)| {
            if group { Group::new(n).unwrap().into() } else { Node::new(n).unwrap().into() }
        },
    )
}

fn property() -> impl Strategy<Value = Property> {
    (0..128_u8).prop_map(|n| Property::new(n).unwrap())
}

fn value() -> impl Strategy<Value = super::super::Value> {
    prop_oneof![any::<i16>().prop_map(super::super::Value::Short), any::<i32>().prop_map(super::super::Value::Long)]
}

fn counts() -> impl Strategy<Value = Counts> {
    (Counts::MIN.get()..=Counts::MAX.get()).prop_map(|n| Counts::new(n).unwrap())
}

fn order() -> impl Strategy<Value = Order> {
    prop_oneof![
        property().prop_map(Order::Get),
        (property(), value()).prop_map(|(p, v)| Order::Set(p, v)),
        any::<[i32; 4]>().prop_map(|slots| Order::Torques(Torques::clamped(slots))),
        prop::array::uniform4(-9000..9000).prop_map(|slots| Order::Torques(Torques::clamped(slots))),
    ]
}

fn map_of_ten() -> impl Strategy<Value = u32> {
    prop::sample::subsequence((0..24_u32).collect::<std::vec::Vec<_>>(), 10)
        .prop_map(|bits| bits.iter().map(|bit| 1 << bit).sum())
}

fn triple() -> impl Strategy<Value = Triple> {
    (any::<[i16; 3]>(), any::<Option<u8>>()).prop_map(|(xyz, flags)| Triple { xyz, flags })
}

fn feedback() -> impl Strategy<Value = Feedback> {
    let cells = prop::array::uniform5(0..=CELL_MAX);
    let values = prop::array::uniform10(0..16_u8);
    prop_oneof![
        (property(), value()).prop_map(|(p, v)| Feedback::Value(p, v)),
        (counts(), prop::option::of(counts()))
            .prop_map(|(primary, secondary)| Feedback::Position(Position { primary, secondary })),
        counts().prop_map(Feedback::Secondary),
        (0..FULL_FRAMES as u8, cells).prop_map(|(n, cells)| Feedback::TactileFull(FullFrame::new(n, cells).unwrap())),
        (map_of_ten(), values).prop_map(|(map, values)| Feedback::TactileTop(Top10::new(map, values).unwrap())),
        triple().prop_map(Feedback::Force),
        triple().prop_map(Feedback::Torque),
        triple().prop_map(Feedback::Acceleration),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn every_command_is_read_as_it_was_sent(to in destination(), order in order()) {
        let command = Command::new(to, order);
        prop_assert_eq!(Message::parse(&command.frame()), Ok(Message::Command(command)));
    }

    #[test]
    fn every_report_is_read_as_it_was_sent(from in node(), feedback in feedback()) {
        match Report::new(from, feedback) {
            Some(report) => prop_assert_eq!(Message::parse(&report.frame()), Ok(Message::Report(report))),
            None => prop_assert_eq!(from, Node::HOST),
        }
    }

    #[test]
    fn a_frame_of_any_content_gives_a_message_that_can_be_sent_or_an_error(
        id in 0..=BASE_ID_MAX,
        data in prop::collection::vec(prop_oneof![any::<u8>(), Just(0xaa), Just(0), Just(0x80)], 0..=8),
    ) {
        let frame = CanFrame::new_base(id, &data, Mtu::Classic).unwrap();
        let again = match Message::parse(&frame) {
            Ok(Message::Command(command)) => command.frame(),
            Ok(Message::Report(report)) => report.frame(),
            Err(_) => return Ok(()),
        };
        prop_assert_eq!(again.id(), frame.id());
        prop_assert_eq!(Message::parse(&again), Message::parse(&frame), "the same message, in its usual form");
    }

    #[test]
    fn a_frame_that_is_not_classic_and_short_is_somebody_elses(id in 0..=ID_MAX, data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let foreign = Err(ParseError::Foreign);
        prop_assert_eq!(Message::parse(&CanFrame::new(id, &data, Mtu::Classic).unwrap()), foreign);
        let fd = CanFrame::new_base(id as u16 & BASE_ID_MAX, &data, Mtu::Fd).unwrap();
        prop_assert_eq!(Message::parse(&fd), foreign);
    }

    #[test]
    fn torques_beyond_14_bits_are_cut_and_others_kept(slots in any::<[i32; 4]>()) {
        let sent = Torques::clamped(slots).slots();
        for (sent, wanted) in sent.iter().zip(slots) {
            prop_assert_eq!(i32::from(*sent), wanted.clamp(-i32::from(TORQUE_MAX), TORQUE_MAX.into()));
        }
    }

    #[test]
    fn an_image_comes_back_whole_whatever_the_order_of_its_frames(
        image in prop::array::uniform24(0..=CELL_MAX),
        order in Just([0_usize, 1, 2, 3, 4]).prop_shuffle(),
    ) {
        let frames = FullFrame::of_image(&image);
        let mut pad = FullImage::default();
        // A frame of an image that was never finished does not count.
        pad.add(&frames[order[4]]);
        prop_assert!(pad.restart());
        for n in &order[..4] {
            prop_assert_eq!(pad.add(&frames[*n]), None);
            prop_assert_eq!(pad.add(&frames[*n]), None, "twice the same is not two");
        }
        prop_assert_eq!(pad.add(&frames[order[4]]), Some(image));
        prop_assert!(!pad.restart());
    }

    #[test]
    fn the_two_readings_of_a_map_name_the_same_pressures_mirrored(map in map_of_ten(), values in prop::array::uniform10(1..16_u8)) {
        let top = Top10::new(map, values).unwrap();
        let (high, low) = (top.cells_n_cm2(MapOrder::HighestFirst), top.cells_n_cm2(MapOrder::LowestFirst));
        for cells in [high, low] {
            let listed: std::vec::Vec<u8> = cells.iter().copied().filter(|cell| *cell > 0).collect();
            prop_assert_eq!(&listed[..], &values[..], "in increasing order of cells");
        }
        for cell in 0..PAD_CELLS {
            prop_assert_eq!(high[cell] > 0, low[PAD_CELLS - 1 - cell] > 0);
        }
    }

    #[test]
    fn motors_and_joints_determine_each_other(q_rad in prop::array::uniform7(-3.0..3.0_f32), tau_nm in prop::array::uniform7(-80.0..80.0_f32)) {
        let back = units::joints_from_motors(&units::motors_from_joints(&q_rad));
        prop_assert!(back.iter().zip(&q_rad).all(|(a, b)| (a - b).abs() < 2e-6), "{back:?} {q_rad:?}");
        let back_nm = units::joint_torques(&units::motor_torques(&tau_nm));
        prop_assert!(back_nm.iter().zip(&tau_nm).all(|(a, b)| (a - b).abs() < 1e-4), "{back_nm:?} {tau_nm:?}");
        // Power in is power out.
        let (motors, torques) = (units::motors_from_joints(&q_rad), units::motor_torques(&tau_nm));
        let power = |speed: &[f32; 7], torque: &[f32; 7]| speed.iter().zip(torque).map(|(a, b)| a * b).sum::<f32>();
        prop_assert!((power(&motors, &torques) - power(&q_rad, &tau_nm)).abs() < 1e-2);
    }

    #[test]
    fn any_number_makes_counts_and_units(value in prop::num::f32::ANY, ipnm in prop::num::f32::ANY) {
        let _ = (units::torque_units(value, ipnm), units::hand_counts(value, 125.0), units::hand_counts_per_ms(value, 17.5));
        let counts = units::arm_counts(value);
        prop_assert!(counts >= Counts::MIN && counts <= Counts::MAX);
        prop_assert!(!value.is_nan() || counts.get() == 0);
    }
}
