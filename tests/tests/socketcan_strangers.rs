//! Promise: nothing that a stranger puts on the bus is taken for readings or commands, and none of it brings an end down.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Sender};
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PAYLOAD_BYTES_MAX};
use tactus_common::link::{self, CONTROLLER, WORLD, priority, subject};
use tactus_common::message::{
    Command, Event, Hello, Message, Phase, PlanAnswer, PlanRequest, RolloutResult, SCHEMA_VERSION, SensorFrame, Setup,
    Status, TactileSlice, node,
};
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{JointReadings, Validity};
use tactus_common::shape::ObjectShape;
use tactus_hil::bus::Bus;
use tactus_hil::socketcan_bus::SocketCanBus;
use tactus_tests::can_bench::{
    Ear, INTERFACE, MISSION, SHORT, SOON, controller, ready_controller, short_digest, world,
};
use tactus_tests::process::Process;
use tactus_tests::rig::header;

/// A version that no build has: ours with all bits turned.
const OLD_VERSION: u64 = !SCHEMA_VERSION;

/// Readings of a robot that does not move.
const AT_REST: JointReadings = JointReadings {
    tick: 0,
    arm_q_rad: [0.0; ARM_JOINTS],
    motor_q_rad: [0.0; HAND_MOTORS],
    inner_q_rad: [0.0; FINGERS],
    effort_nm: [0.0; HAND_MOTORS],
    tip_torque_nm: [0.0; FINGERS],
    valid: Validity::ALL,
};

/// Sends a message as one of the ends would.
fn say<M: Message>(bus: &mut SocketCanBus, source: NodeId, message: &M) {
    let mut buffer = [0; PAYLOAD_BYTES_MAX];
    let bytes = link::encode(message, &mut buffer).expect("it fits");
    let mut sender = Sender::new(source, [subject::<M>()]);
    let frames: Vec<CanFrame> = sender.send(subject::<M>(), priority::<M>(), bytes, Mtu::Fd).expect("one").collect();
    for frame in frames {
        bus.send(frame).expect("vcan0 is up");
    }
}

fn bus() -> SocketCanBus {
    SocketCanBus::open(INTERFACE, None, &[]).expect("vcan0 is up")
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_controller_of_another_version_is_refused_by_the_world_which_names_both_and_takes_the_right_one() {
    let mut world = world(&SHORT);
    world.wait_for("waiting for a controller", SOON);
    say(&mut bus(), CONTROLLER, &Hello { schema_version: OLD_VERSION.to_le_bytes() });
    let line = world.wait_for(&format!("{OLD_VERSION:016x}"), SOON);
    assert!(line.contains(&format!("{SCHEMA_VERSION:016x}")), "{line}");
    let _controller = ready_controller(&["--once"]);
    let (status, lines) = world.end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_world_of_another_version_is_refused_by_the_controller_which_names_both() {
    let mut controller = ready_controller(&["--once"]);
    let setup = Setup {
        schema_version: OLD_VERSION.to_le_bytes(),
        shape: ObjectShape::Cuboid { half_extents_m: [0.1, 0.05, 0.1] },
        guess: PlanarPose::new(0.2, -0.1, 0.0),
        interval: Interval { x_m: 0.05, y_m: 0.0, phi_rad: 0.0 },
        displacement_m: [-0.5, 0.0],
        mass_kg: 0.6,
        trials_max: 8,
    };
    let mut bus = bus();
    say(&mut bus, WORLD, &setup);
    say(&mut bus, WORLD, &SensorFrame::pack(&AT_REST));
    let line = controller.wait_for(&format!("{OLD_VERSION:016x}"), SOON);
    assert!(line.contains(&format!("{SCHEMA_VERSION:016x}")), "{line}");
    let (status, lines) = controller.end(SOON);
    assert_eq!(status.code(), Some(2), "{lines:?}");
}

/// Does the summary in these lines have the digest of a mission that nobody has disturbed?
fn undisturbed(lines: &[String]) -> bool {
    lines.iter().any(|line| line.contains(short_digest()))
}

/// Runs a mission beside programs that talk nonsense; its exit status, what the world said, what the controller said.
fn beside(nonsense: &[String]) -> (Option<i32>, Vec<String>, Vec<String>) {
    let mut controller = ready_controller(&["--once"]);
    let mut ear = Ear::open();
    let world = world(&[&SHORT[..], &["--summary", "-"]].concat());
    ear.wait_for_phase(Phase::Plan, MISSION);
    let start = |line: &String| Process::start("cangen", &line.split_whitespace().collect::<Vec<_>>());
    let mut floods: Vec<Process> = nonsense.iter().map(start).collect();
    let begun = std::time::Instant::now();
    let (status, lines) = world.end(MISSION * 2);
    println!("{nonsense:?}: {:.1} s, {status}", begun.elapsed().as_secs_f32());
    for flood in &mut floods {
        assert!(!flood.has_ended(), "{nonsense:?} ended early: {:?}", flood.lines());
    }
    drop(floods);
    let (_, said) = match controller.has_ended() {
        true => controller.end(SOON),
        false => {
            controller.kill();
            (status, controller.lines())
        }
    };
    for line in lines.iter().chain(&said) {
        assert!(!line.contains("panicked"), "{line}");
    }
    (status.code(), lines, said)
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn random_identifiers_lengths_and_contents_change_nothing() {
    let nonsense =
        ["-g 1 -m -I r -L r -D r -i", "-g 2 -m -e -I r -L r -D r -i"].map(|how| format!("{INTERFACE} {how}"));
    let (status, lines, said) = beside(&nonsense);
    assert_eq!(status, Some(0), "{lines:?}");
    assert!(undisturbed(&lines), "{lines:?} {said:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn nonsense_under_our_own_identifiers_ends_in_success_or_with_a_reason_and_brings_nobody_down() {
    let cangen = |header: Header, rest: &str| format!("{INTERFACE} -g 20 -i -e -I {:08X} {rest}", header.id());
    let (world, controller) = (node::WORLD, node::CONTROLLER);
    for nonsense in [
        &[cangen(header::<SensorFrame>(world), "-f -L 64 -D r")][..],
        &[cangen(header::<Command>(controller), "-L r -D r")],
        // All the others at once.
        &[
            cangen(header::<Setup>(world), "-L r -D r"),
            cangen(header::<TactileSlice>(world), "-f -L 48 -D r"),
            cangen(header::<PlanAnswer>(world), "-L 8 -D r"),
            cangen(header::<RolloutResult>(world), "-f -L r -D r"),
            cangen(header::<PlanRequest>(controller), "-f -L 64 -D r"),
            cangen(header::<Event>(controller), "-L r -D r"),
            cangen(header::<Status>(controller), "-f -L r -D r"),
        ],
    ] {
        let (status, lines, said) = beside(nonsense);
        assert!(matches!(status, Some(0 | 3 | 4)), "{nonsense:?}: {status:?} {lines:?}");
        // Readings and commands that were lost are asked for again. Of what is said but once, a loss is not made up for.
        assert!(nonsense.len() > 1 || undisturbed(&lines), "a wrong value was taken: {nonsense:?}: {lines:?} {said:?}");
    }
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_controller_without_a_world_outlives_any_flood_and_serves_the_next_world() {
    let mut controller = controller(&[]);
    controller.wait_for("ready", SOON);
    for id in [header::<Setup>(node::WORLD).id(), header::<SensorFrame>(node::WORLD).id()] {
        let line = format!("{INTERFACE} -g 0 -e -f -I {id:08X} -L r -D r -n 2000 -i");
        let (status, lines) = Process::start("cangen", &line.split_whitespace().collect::<Vec<_>>()).end(SOON);
        assert!(status.success(), "{lines:?}");
    }
    let (status, lines) = world(&SHORT).end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
}
