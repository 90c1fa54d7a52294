//! Promises about objects that slip in the hand: it is noticed, gripped harder and carried; what no grip holds ends the
//! mission with a reason; what is held firmly is never said to slip. The controller is told nothing of friction.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use tactus_common::message::{EventKind, FailureReason, Outcome};
use tactus_sim_host::mission::{self, MissionOptions, MissionReport, guess_around};
use tactus_sim_host::observer::{Observer, Seen};
use tactus_sim_host::scenario::Scenario;
use tactus_tests::program::run;
use tactus_tests::recording::options;

/// The scene of a box that the first grip lets slide.
const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../sim-host/scenarios/heavy_slippery_box.toml");

/// Seeds of worlds in which the first grip does not hold that box, and a harder one does.
const SLIPPERY: [u64; 3] = [1, 2, 4];
/// Friction at which no grip holds it.
const HOPELESS_FRICTION: f32 = 0.15;

fn scene() -> Scenario {
    Scenario::load(Path::new(SCENE)).expect("the scene is sound")
}

fn options_in(scenario: Scenario, seed: u64) -> MissionOptions {
    let shipped = options(seed);
    let truth = scenario.true_pose();
    MissionOptions { guess: guess_around(&truth, &shipped.interval, seed), truth, scenario, ..shipped }
}

/// Steps that were taken against slip: tick, finger, torque in newton-metres.
#[derive(Default)]
struct Slips(Vec<(u32, u8, f32)>);

impl Observer for Slips {
    fn see(&mut self, seen: &Seen) -> anyhow::Result<()> {
        for event in &seen.heard.events {
            if let EventKind::Slip { finger, grip_nm, .. } = event.kind {
                self.0.push((event.tick, finger, grip_nm));
            }
        }
        Ok(())
    }
}

/// A mission and the steps that it took against slip.
fn carry(options: &MissionOptions) -> (MissionReport, Vec<(u32, u8, f32)>) {
    let mut slips = Slips::default();
    let report = mission::run(options, &mut slips).expect("the simulation holds");
    (report, slips.0)
}

#[test]
fn a_heavy_slippery_box_is_felt_to_slip_gripped_harder_and_carried_to_its_goal() {
    for seed in SLIPPERY {
        let (report, slips) = carry(&options_in(scene(), seed));
        println!(
            "seed {seed}: {} after {slips:?}; {:.1} mm, {:.2} deg off",
            report.outcome_text(),
            report.goal_position_error_m * 1e3,
            report.goal_yaw_error_rad.to_degrees()
        );
        assert!(!slips.is_empty(), "seed {seed}: nothing was felt");
        assert!(report.transported(), "seed {seed}: {}", report.outcome_text());
    }
}

#[test]
fn the_scene_is_carried_by_the_command_as_people_run_it() {
    let ran = run(&["run", "--scenario", SCENE]);
    assert_eq!(ran.status, 0, "{}{}", ran.stdout, ran.stderr);
}

#[test]
fn a_box_that_no_grip_holds_ends_the_mission_with_a_reason() {
    let mut scenario = scene();
    scenario.object.friction = HOPELESS_FRICTION;
    let (report, slips) = carry(&options_in(scenario, 1));
    println!("{} after {slips:?}", report.outcome_text());
    assert!(!slips.is_empty(), "nothing was felt");
    let reasons = [FailureReason::ObjectLost, FailureReason::NotConfident, FailureReason::GraspMissed];
    assert!(reasons.map(|reason| Some(Outcome::Failed(reason))).contains(&report.outcome), "{:?}", report.outcome);
    assert_eq!(report.exit_status(), 3);
}

#[test]
fn the_thesis_box_never_slips_in_ten_worlds() {
    let next = AtomicU64::new(1);
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed > 10 {
                        break;
                    }
                    let (report, slips) = carry(&options(seed));
                    assert_eq!(slips, [], "seed {seed}");
                    assert!(report.transported(), "seed {seed}: {}", report.outcome_text());
                }
            });
        }
    });
}
