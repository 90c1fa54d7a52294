//! Promise: nothing that a stranger puts on the bus is taken for readings or commands, and none of it brings an end down.

use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Sender};
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, OBSTACLES_MAX, PAYLOAD_BYTES_MAX};
use tactus_common::link::{self, CONTROLLER, WORLD, priority, subject};
use tactus_common::message::{
    Command, Event, Hello, Message, Phase, PlanAnswer, PlanRequest, RolloutResult, SCHEMA_VERSION, SensorFrame, Setup,
    Status, TactileSlice,
};
use tactus_common::method::Method;
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
        obstacles: [None; OBSTACLES_MAX],
        displacement_m: [-0.5, 0.0],
        mass_kg: 0.6,
        trials_max: 8,
        robot_base: tactus_common::robot::MOUNT,
        method: Method::default(),
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

/// Runs a mission beside programs that talk nonsense; its exit status and what both ends said. `None`: the world said that
/// it lost its controller, and waits for another one.
fn beside(nonsense: &[String]) -> (Option<i32>, Vec<String>) {
    let mut controller = ready_controller(&[]);
    let mut ear = Ear::open();
    let mut world = world(&[&SHORT[..], &["--summary", "/dev/stdout"]].concat());
    ear.wait_for_phase(Phase::Plan, MISSION);
    let start = |line: &String| Process::start("cangen", &line.split_whitespace().collect::<Vec<_>>());
    let mut floods: Vec<Process> = nonsense.iter().map(start).collect();
    let begun = Instant::now();
    let lost = |lines: &[String]| lines.iter().any(|line| line.contains("controller lost"));
    while !world.has_ended() && !lost(&world.lines()) {
        let said = (world.lines(), controller.lines());
        assert!(begun.elapsed() < MISSION * 2, "{nonsense:?}: neither an end nor a reason: {said:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
    for flood in &mut floods {
        assert!(!flood.has_ended(), "{nonsense:?} ended early: {:?}", flood.lines());
    }
    drop(floods);
    assert!(!controller.has_ended(), "{:?}", controller.lines());
    controller.kill();
    let said = controller.lines();
    let (status, mut lines) = if lost(&world.lines()) {
        world.kill();
        (None, world.lines())
    } else {
        let (status, lines) = world.end(SOON);
        (status.code(), lines)
    };
    println!("{nonsense:?}: {:.1} s, {status:?}, {:?}", begun.elapsed().as_secs_f32(), said.last());
    lines.extend(said);
    let panicked = lines.iter().find(|line| line.contains("panicked"));
    assert_eq!(panicked, None);
    (status, lines)
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn random_identifiers_lengths_and_contents_change_nothing() {
    let nonsense =
        ["-g 1 -m -I r -L r -D r -i", "-g 2 -m -e -I r -L r -D r -i"].map(|how| format!("{INTERFACE} {how}"));
    let (status, lines) = beside(&nonsense);
    assert_eq!(status, Some(0), "{lines:?}");
    assert!(undisturbed(&lines), "{lines:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn nonsense_under_our_own_identifiers_ends_in_success_or_with_a_reason_and_brings_nobody_down() {
    let cangen = |header: Header, rest: &str| format!("{INTERFACE} -i -e -I {:08X} {rest}", header.id());
    for nonsense in [
        &[cangen(header::<SensorFrame>(WORLD), "-g 20 -f -L 64 -D r")][..],
        // Each of these that is taken for a transfer makes up to 15 answers look old, 50 ms each.
        &[cangen(header::<Command>(CONTROLLER), "-g 100 -L r -D r")],
        // All the others at once.
        &[
            cangen(header::<Setup>(WORLD), "-g 20 -L r -D r"),
            cangen(header::<TactileSlice>(WORLD), "-g 20 -f -L 48 -D r"),
            cangen(header::<PlanAnswer>(WORLD), "-g 20 -L 8 -D r"),
            cangen(header::<RolloutResult>(WORLD), "-g 20 -f -L r -D r"),
            cangen(header::<PlanRequest>(CONTROLLER), "-g 20 -f -L 64 -D r"),
            cangen(header::<Event>(CONTROLLER), "-g 20 -L r -D r"),
            cangen(header::<Status>(CONTROLLER), "-g 20 -f -L r -D r"),
        ],
    ] {
        let (status, lines) = beside(nonsense);
        assert!(matches!(status, None | Some(0 | 3 | 4)), "{nonsense:?}: {status:?} {lines:?}");
        // Readings and commands that were lost are asked for again. Of what is said but once, a loss is not made up for.
        let sound = status != Some(0) || nonsense.len() > 1 || undisturbed(&lines);
        assert!(sound, "a wrong value was taken: {nonsense:?}: {lines:?}");
    }
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_controller_without_a_world_outlives_any_flood_and_serves_the_next_world() {
    let mut controller = controller(&[]);
    controller.wait_for("ready", SOON);
    for id in [header::<Setup>(WORLD).id(), header::<SensorFrame>(WORLD).id()] {
        let line = format!("{INTERFACE} -g 0 -e -f -I {id:08X} -L r -D r -n 2000 -i");
        let (status, lines) = Process::start("cangen", &line.split_whitespace().collect::<Vec<_>>()).end(SOON);
        assert!(status.success(), "{lines:?}");
    }
    let (status, lines) = world(&SHORT).end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
}
