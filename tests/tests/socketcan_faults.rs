//! Promise: whichever end of a real bus dies, the robot ends in its safe state, somebody says so, and a new start works.

use std::time::{Duration, Instant};
use tactus_common::message::Phase;
use tactus_tests::can_bench::{
    BUS, Ear, INTERFACE, MISSION, SHORT, SOON, controller, controller_path, ready_controller, set_link, short_digest,
    world,
};
use tactus_tests::process::Process;

/// Phases in which a controller can be killed, in the order of a mission.
const PHASES: [Phase; 6] = [Phase::Plan, Phase::Trial, Phase::Update, Phase::Grasp, Phase::Transport, Phase::Release];

/// The whole number behind `text` in a line.
fn number_after(line: &str, text: &str) -> i64 {
    let rest = line.split(text).nth(1).unwrap_or_else(|| panic!("no \"{text}\" in {line}"));
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().unwrap_or_else(|_| panic!("no number behind \"{text}\" in {line}"))
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_controller_killed_in_any_phase_is_reported_the_arm_let_go_and_a_new_controller_taken() {
    let mut world = world(&SHORT);
    for (killed, phase) in PHASES.into_iter().enumerate() {
        let mut ear = Ear::open();
        let mut controller = ready_controller(&[]);
        ear.wait_for_phase(phase, MISSION);
        controller.kill();
        // Its last frames may have told of the phase, and the command of that tick never came.
        let lost = world.wait_for_nth("controller lost in phase", killed + 1, SOON);
        let released = world.wait_for_nth("the arm is released: no torque since tick", killed + 1, SOON);
        println!("{phase:?}: {lost}; {released}");
        // The drives' own watch: 20 ticks without a command.
        assert_eq!(number_after(&released, "since tick ") - number_after(&lost, "since tick "), 19);
        world.wait_for_nth("waiting for a controller", killed + 2, SOON);
    }
    let _controller = ready_controller(&["--once"]);
    let (status, lines) = world.end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
    assert!(lines.iter().any(|line| line.contains("mission 1 over: transported")), "{lines:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_world_killed_in_lockstep_leaves_a_controller_that_is_safe_after_two_seconds_and_takes_a_new_world() {
    let mut controller = ready_controller(&[]);
    let mut ear = Ear::open();
    let mut first = world(&SHORT);
    ear.wait_for_phase(Phase::Trial, MISSION);
    first.kill();
    let killed = Instant::now();
    let line = controller.wait_for("no frame from the world for", SOON);
    let silent = killed.elapsed();
    assert!(line.contains("made safe"), "{line}");
    assert!((1_800..4_000).contains(&silent.as_millis()), "safe after 2 s, not {silent:?}");
    assert!(controller.wait_for("mission over", SOON).contains("HostSilent"));

    let second = world(&SHORT);
    let (status, lines) = second.end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
    assert!(controller.wait_for_nth("mission over", 2, SOON).contains("Transported"));
    assert!(
        controller.wait_for_nth("mission over", 2, SOON).contains(short_digest()),
        "nothing of the first mission is left"
    );
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_world_killed_in_real_time_leaves_a_controller_that_is_safe_after_twenty_periods() {
    let mut controller = ready_controller(&["--pace", "realtime"]);
    let mut ear = Ear::open();
    let mut world = world(&[&SHORT[..], &["--pace", "realtime"]].concat());
    ear.wait_for_phase(Phase::Plan, MISSION);
    world.kill();
    let line = controller.wait_for("no frame from the world for", SOON);
    let seconds = line.split_whitespace().filter_map(|word| word.parse::<f32>().ok()).next_back().expect("how long");
    // 20 periods are 40 ms; it is looked at every 10 ms, and this machine may be busy.
    assert!((0.040..0.500).contains(&seconds), "{line}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn an_interface_that_is_down_for_a_moment_costs_time_and_nothing_else() {
    let digest = short_digest();
    let mut controller = ready_controller(&["--once"]);
    let mut ear = Ear::open();
    let world = world(&[&SHORT[..], &["--summary", "-"]].concat());
    ear.wait_for_phase(Phase::Trial, MISSION);
    set_link("down");
    std::thread::sleep(Duration::from_millis(300));
    set_link("up");
    let (status, lines) = world.end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
    assert!(lines.iter().any(|line| line.contains(digest)), "{digest} in {lines:?}");
    controller.wait_for("Transported", SOON);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn an_interface_that_stays_down_ends_the_mission_with_a_reason_and_the_next_one_is_taken_when_it_is_up() {
    let mut controller = ready_controller(&[]);
    let mut ear = Ear::open();
    let first = world(&SHORT);
    ear.wait_for_phase(Phase::Trial, MISSION);
    set_link("down");
    let down = Instant::now();
    // Neither end hangs, and both do so within the time that they grant each other, and a little more.
    controller.wait_for("made safe", SOON);
    let (status, lines) = first.end(SOON);
    println!("both had a reason to end after {:?}", down.elapsed());
    set_link("up");
    assert_eq!(status.code(), Some(2), "{lines:?}");
    assert!(lines.iter().any(|line| line.starts_with("error: ") && line.contains("the bus is down")), "{lines:?}");
    let (status, lines) = world(&SHORT).end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
    controller.wait_for("Transported", SOON);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_second_controller_is_refused_and_the_first_one_finishes_its_mission_and_says_who_was_there() {
    let digest = short_digest();
    let mut first = ready_controller(&["--once"]);
    let mut ear = Ear::open();
    let world = world(&[&SHORT[..], &["--summary", "-"]].concat());
    ear.wait_for_phase(Phase::Trial, MISSION);
    let (status, lines) = controller(&["--once"]).end(SOON);
    assert_eq!(status.code(), Some(2), "{lines:?}");
    assert!(
        lines.iter().any(|l| l == &format!("error: --bus {BUS}: another controller is on this bus; stop it first")),
        "{lines:?}"
    );
    assert!(first.wait_for("another controller with node id 20 is on this bus", SOON).contains(INTERFACE));
    let (status, lines) = world.end(MISSION);
    assert_eq!(status.code(), Some(0), "{lines:?}");
    assert!(lines.iter().any(|line| line.contains(digest)), "not disturbed: {digest} in {lines:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn without_the_interface_every_program_says_in_one_line_what_was_expected() {
    let tactus = tactus_tests::program::path(tactus_tests::program::Profile::Release);
    for (program, args) in [
        (controller_path(), &["--bus", "socketcan:nosuch0"][..]),
        (tactus.clone(), &["serve", "--bus", "socketcan:nosuch0"]),
        (tactus, &["run", "--bus", "socketcan:nosuch0"]),
    ] {
        let (status, lines) = Process::start(&program, args).end(SOON);
        assert_eq!(status.code(), Some(2), "{lines:?}");
        let [line] = &lines[..] else { panic!("one line: {lines:?}") };
        assert!(line.contains("no CAN interface nosuch0; expected"), "{line}");
    }
}
