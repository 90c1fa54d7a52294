//! Promises of the start-up.

extern crate std;

use super::super::startup::{StartError, StartState, Startup};
use super::{motor, report};
use std::string::String;
use std::vec::Vec;
use tactus_common::puck::property::safety;
use tactus_common::puck::{Destination, Feedback, Message, Node, Order, Property, Value};

/// What a healthy robot answers.
fn healthy(node: Node, property: Property) -> i32 {
    match (node, property) {
        (_, motor::STAT) => 2,
        (_, motor::VERS) => 200,
        (Node::SAFETY, safety::ZERO) => 1,
        (Node::SAFETY, motor::MODE) => 2,
        (_, motor::ROLE) if node.arm_motor().is_some() => 0x0100,
        (_, motor::ROLE) => {
            if node == Node::HAND[3] {
                0x1005
            } else {
                0x1805
            }
        }
        (_, motor::CTS) => 4096,
        (_, motor::IPNM) => {
            if node.arm_motor().is_some() {
                2000 + i32::from(node.get())
            } else {
                20_000
            }
        }
        (_, motor::POLES) => 6,
        _ => panic!("{node:?} asked {property:?}"),
    }
}

/// Starts a robot; `answers` may change what it says. How it ends, and what was sent.
fn start(mut answers: impl FnMut(u32, Node, Property) -> Option<i32>) -> (StartState, Vec<String>) {
    let mut startup = Startup::default();
    let mut log = Vec::new();
    for tick in 0..5_000 {
        let mut sent = Vec::new();
        startup.tick(&mut |frame| sent.push(frame));
        for frame in sent {
            log.push(std::format!("{frame:?}"));
            let Ok(Message::Command(asked)) = Message::parse(&frame) else { panic!("{frame:?}") };
            let (Order::Get(property), Destination::Node(node)) = (asked.order(), asked.address().to) else {
                panic!("{frame:?}")
            };
            if let Some(value) = answers(tick, node, property) {
                let value = Feedback::Value(property, Value::Long(value));
                // Not from here, and not this.
                startup.receive(&report(Node::FORCE, value), &mut |_| panic!("not asked"));
                startup
                    .receive(&report(node, Feedback::Value(motor::SN, Value::Short(2))), &mut |_| panic!("not asked"));
                startup.receive(&report(node, value), &mut |frame| log.push(std::format!("{frame:?}")));
            }
        }
        if !matches!(startup.state(), StartState::Asking | StartState::AwaitsOperator) {
            break;
        }
    }
    (startup.state(), log)
}

#[test]
fn a_healthy_robot_is_ready_with_its_own_torque_units_and_tared_pads() {
    let (state, log) = start(|_, node, property| Some(healthy(node, property)));
    let StartState::Ready(calibration) = state else { panic!("{state:?}") };
    assert_eq!(calibration.arm_ipnm, [2001.0, 2002.0, 2003.0, 2004.0, 2005.0, 2006.0, 2007.0]);
    assert_eq!(calibration.hand_ipnm, [20_000.0; 4]);
    assert_eq!(log.first().map(String::as_str), Some("00A#05"));
    assert_eq!(
        log[log.len() - 6..],
        ["00A#2A", "00A#08", "00B#EA000300", "00C#EA000300", "00D#EA000300", "00E#EA000300"]
    );
}

#[test]
fn a_robot_that_does_not_fit_is_refused_with_the_reason() {
    use StartError::*;
    let cases = [
        (Node::ARM[3], motor::VERS, 144, Firmware(Node::ARM[3], 144)),
        (Node::HAND[1], motor::STAT, 1, NotReady(Node::HAND[1])),
        (Node::HAND[2], motor::ROLE, 0x1005, Role(Node::HAND[2], 0x1005)),
        (Node::ARM[0], motor::ROLE, 5, Role(Node::ARM[0], 5)),
        (Node::ARM[6], motor::CTS, 40_960, Counts(Node::ARM[6], 40_960)),
        (Node::ARM[6], motor::POLES, 8, NoWrist(8)),
        (Node::ARM[5], motor::IPNM, 0, TorqueUnit(Node::ARM[5], 0)),
        (Node::SAFETY, safety::ZERO, 0, NotZeroed),
    ];
    for (node, property, value, error) in cases {
        let answers = |_, n, p| Some(if (n, p) == (node, property) { value } else { healthy(n, p) });
        assert_eq!(start(answers).0, StartState::Failed(error));
    }
}

#[test]
fn a_node_that_does_not_answer_is_asked_three_times_and_named() {
    let answers = |_, node, property| (node != Node::HAND[0]).then(|| healthy(node, property));
    let (state, log) = start(answers);
    assert_eq!(state, StartState::Failed(StartError::Silent(Node::HAND[0])));
    assert_eq!(log.iter().filter(|frame| *frame == "00B#05").count(), 3);
}

#[test]
fn a_sleeping_puck_is_woken_and_an_idle_robot_waited_for() {
    let mut asleep = true;
    let (state, log) = start(|tick, node, property| match (node, property) {
        (Node::SAFETY, motor::MODE) if tick < 2_000 => Some(1),
        (_, motor::STAT) if node == Node::ARM[1] && core::mem::take(&mut asleep) => Some(0),
        _ => Some(healthy(node, property)),
    });
    assert!(matches!(state, StartState::Ready(_)), "{state:?}");
    assert!(log.contains(&String::from("002#850002000000")), "{log:?}");
    assert!(log.iter().filter(|frame| *frame == "00A#08").count() > 10);
    let dead = start(|_, node, property| {
        Some(if (node, property) == (Node::ARM[1], motor::STAT) { 0 } else { healthy(node, property) })
    });
    assert_eq!(dead.0, StartState::Failed(StartError::NotReady(Node::ARM[1])));
}
