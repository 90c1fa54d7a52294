//! Promise: whatever goes wrong, in whatever phase, the robot is made safe and the reason is told. Faults are injected at
//! the first tick of every phase and at many ticks within; every command on the way stays within the torque limits (the
//! rig looks at each).

use std::collections::BTreeSet;
use tactus_common::limits::{ARM_JOINTS, SILENCE_TICKS_MAX};
use tactus_common::link::subject;
use tactus_common::message::{
    EventKind, FailureReason, FaultReason, Outcome, Phase, PlanAnswer, Purpose, RefusalReason, SensorFrame,
};
use tactus_common::reading::{JointReadings, Validity};
use tactus_common::robot::ARM_LIMITS;
use tactus_tests::recording::{PHASES, Recording, options, run_tampered};
use tactus_tests::rig::{Rig, Said, Told, is_hold, is_limp};

/// Ticks between two places at which a fault is injected.
const EVERY: u32 = 149;
/// Ticks for which the safe state is watched: 1 s.
const WATCHED: u32 = 500;
/// Ticks after which a host that does not answer is given up: 10 s, and one to tell.
const ANSWER_TICKS: u32 = 5_000;

/// Rigs in every phase of the default mission, and after a mission that failed.
fn everywhere() -> Vec<Rig> {
    let stops = Recording::shared().stops(EVERY);
    let seen: BTreeSet<Phase> = stops.iter().map(Rig::phase).collect();
    for phase in PHASES {
        assert!(seen.contains(&phase), "the mission goes through {phase:?}");
    }
    let mut stops = stops;
    stops.push(failed());
    println!("{} places, phases {seen:?} and Failed", stops.len());
    stops
}

/// A rig whose planner refused everything.
fn failed() -> Rig {
    let mut rig = Rig::new();
    let mut said = Said::default();
    for told in &Recording::shared().told {
        said = rig.tell(told);
        if told.setup.is_some() {
            break;
        }
    }
    for _ in 0..2_000 {
        let plan = said.plan.map(|request| PlanAnswer {
            effective: rig.tick() + 1,
            request: request.request,
            result: Err(RefusalReason::OutOfReach),
        });
        let mut readings = rig.readings();
        readings.tick = rig.tick() + 1;
        said = rig.tell(&Told { plan, sensors: Some(SensorFrame::pack(&readings)), ..Told::default() });
        if let Some(outcome) = said.finished() {
            assert_eq!(outcome, Outcome::Failed(FailureReason::NoPlan(RefusalReason::OutOfReach)));
            assert_eq!(rig.phase(), Phase::Failed);
            return rig;
        }
    }
    panic!("a mission whose planner refuses everything must fail");
}

/// The fault must have been told exactly once by these answers, and the phase must be `Fault`.
fn told_once(rig: &Rig, said: &[Said], reason: FaultReason) {
    let faults: Vec<FaultReason> = said.iter().filter_map(Said::fault).collect();
    assert_eq!(faults, [reason], "tick {}", rig.tick());
    let phases = said.iter().flat_map(|s| &s.events).filter(|e| e.kind == EventKind::Phase(Phase::Fault)).count();
    assert_eq!((rig.phase(), phases), (Phase::Fault, 1), "tick {}", rig.tick());
    assert_eq!(rig.node.controller().outcome(), Some(Outcome::Fault(reason)));
}

/// Good readings for a while: the robot stays limp.
fn stays_limp(rig: &mut Rig) {
    for _ in 0..WATCHED {
        let said = rig.sense(|_| ());
        assert!(is_limp(&said.commands()), "tick {}: {said:?}", rig.tick());
        assert_eq!(said.events, [], "nothing happens any more");
    }
}

/// Good readings for a while: the robot holds.
fn stays_held(rig: &mut Rig) {
    for _ in 0..WATCHED {
        let said = rig.sense(|_| ());
        assert!(is_hold(&said.commands()), "tick {}: {said:?}", rig.tick());
        assert_eq!(said.events, [], "nothing happens any more");
    }
}

#[test]
fn silence_of_twenty_ticks_makes_limp_at_the_twentieth() {
    for mut rig in everywhere() {
        let said: Vec<Said> = (0..SILENCE_TICKS_MAX).map(|_| rig.silence()).collect();
        let (last, before) = said.split_last().unwrap();
        assert!(before.iter().all(|s| s.fault().is_none()), "not before the twentieth");
        assert!(is_limp(&last.commands()), "{last:?}");
        told_once(&rig, &said, FaultReason::HostSilent);
        // A world that comes back finds the robot safe.
        stays_limp(&mut rig);
    }
}

#[test]
fn silence_of_nineteen_ticks_is_bridged() {
    for mut rig in everywhere() {
        for _ in 1..SILENCE_TICKS_MAX {
            assert_eq!(rig.silence().fault(), None);
        }
        for _ in 0..3 {
            assert_eq!(rig.sense(|_| ()).fault(), None, "tick {}", rig.tick());
        }
        assert_ne!(rig.phase(), Phase::Fault);
    }
}

#[test]
fn angles_that_are_not_finite_or_not_measured_make_limp() {
    let ways: [fn(&mut JointReadings); 5] = [
        |r| r.arm_q_rad[3] = f32::NAN,
        |r| r.arm_q_rad = [f32::INFINITY; ARM_JOINTS],
        |r| r.valid = Validity::NONE,
        |r| r.motor_q_rad[1] = f32::NEG_INFINITY,
        |r| r.tip_torque_nm[2] = f32::NAN,
    ];
    for rig in everywhere() {
        for spoil in ways {
            let mut rig = rig.clone();
            let said: Vec<Said> = (0..4).map(|_| rig.sense(spoil)).collect();
            assert!(is_limp(&said[3].commands()), "{said:?}");
            told_once(&rig, &said, FaultReason::SensorInvalid);
        }
    }
}

#[test]
fn every_reading_is_needed_but_the_efforts() {
    let start = Recording::shared().play(|rig, _| rig.phase() != Phase::Trial);
    // Bits 14-17 are the efforts, which the real hand does not tell.
    for bit in (0..14).chain(18..21) {
        let mut rig = start.clone();
        let said: Vec<Said> =
            (0..4).map(|_| rig.sense(|r| r.valid = Validity(Validity::ALL.0 & !(1 << bit)))).collect();
        told_once(&rig, &said, FaultReason::SensorInvalid);
        stays_limp(&mut rig);
    }
}

#[test]
fn one_bad_tick_is_bridged() {
    for mut rig in everywhere() {
        assert_eq!(rig.sense(|r| r.arm_q_rad[0] = f32::NAN).fault(), None);
        assert_eq!(rig.sense(|_| ()).fault(), None);
        assert_ne!(rig.phase(), Phase::Fault);
    }
}

#[test]
fn a_joint_out_of_its_range_is_held_and_named() {
    for rig in everywhere() {
        for (joint, limit) in ARM_LIMITS.iter().enumerate() {
            for out in [limit.lower_rad - 0.03, limit.upper_rad + 0.03] {
                let mut rig = rig.clone();
                let said = rig.sense(|r| r.arm_q_rad[joint] = out);
                assert!(is_hold(&said.commands()), "J{}: {said:?}", joint + 1);
                told_once(&rig, &[said], FaultReason::JointLimit(joint as u8));
            }
        }
    }
}

#[test]
fn a_joint_that_runs_away_is_held_and_named() {
    for rig in everywhere() {
        for joint in 0..ARM_JOINTS {
            let mut rig = rig.clone();
            let mut said = Vec::new();
            for tick in 1..=8 {
                // 10 rad/s, away from the nearer limit.
                let direction = if rig.readings().arm_q_rad[joint] > 0.0 { -1.0 } else { 1.0 };
                said.push(rig.sense(|r| r.arm_q_rad[joint] += direction * 0.02 * tick as f32));
            }
            told_once(&rig, &said, FaultReason::JointSpeed(joint as u8));
            assert!(is_hold(&said[7].commands()));
        }
    }
}

#[test]
fn an_arm_that_does_not_follow_is_held() {
    // The readings stop changing while the reference moves on.
    let mut stuck = BTreeSet::new();
    for mut rig in everywhere() {
        let phase = rig.phase();
        let mut said = Vec::new();
        for _ in 0..1_500 {
            said.push(rig.sense(|_| ()));
            if rig.phase() == Phase::Fault {
                break;
            }
        }
        if let Some(reason) = said.iter().find_map(Said::fault) {
            assert!(matches!(reason, FaultReason::Tracking(_)), "{phase:?}: {reason:?}");
            told_once(&rig, &said, reason);
            stays_held(&mut rig);
            stuck.insert(phase);
        }
    }
    for phase in [Phase::Trial, Phase::Grasp, Phase::Transport, Phase::Release] {
        assert!(stuck.contains(&phase), "the arm moves in {phase:?}, so it can be stuck there; noticed in {stuck:?}");
    }
}

#[test]
fn a_host_that_never_answers_is_given_up_after_ten_seconds() {
    let mut asked = Vec::new();
    Recording::shared().play(|rig, said| {
        if let Some(request) = &said.plan {
            let first = asked.iter().all(|(purpose, _)| *purpose != Some(request.purpose));
            if first {
                asked.push((Some(request.purpose), rig.clone()));
            }
        }
        if said.rollout.is_some() {
            asked.push((None, rig.clone()));
        }
        true
    });
    let purposes: Vec<Option<Purpose>> = asked.iter().map(|(purpose, _)| *purpose).collect();
    for purpose in [Some(Purpose::Touch), Some(Purpose::Grasp), Some(Purpose::Transport), None] {
        assert!(purposes.contains(&purpose), "the mission asks for {purpose:?}");
    }
    for (purpose, mut rig) in asked {
        let phase = rig.phase();
        let mut said = Vec::new();
        while said.len() < ANSWER_TICKS as usize + 5 && rig.phase() != Phase::Fault {
            assert_eq!(rig.phase(), phase);
            said.push(rig.sense(|_| ()));
        }
        assert!(said.len() >= ANSWER_TICKS as usize, "{purpose:?}: after {} ticks", said.len());
        told_once(&rig, &said, FaultReason::HostSlow);
        stays_held(&mut rig);
    }
}

#[test]
fn answers_to_other_questions_and_trajectories_that_are_not_sound_move_nothing() {
    let recording = Recording::shared();
    let answer = recording.told.iter().find_map(|told| told.plan.clone()).expect("a trajectory");
    let mut start = None;
    recording.play(|rig, said| {
        start = said.plan.is_some().then(|| rig.clone());
        start.is_none()
    });
    let start = start.expect("the mission asks for a trajectory");
    let Ok(good) = &answer.result else { panic!("the first answer is a trajectory") };
    let with = |change: fn(&mut tactus_common::trajectory::Trajectory)| {
        let mut trajectory = good.clone();
        change(&mut trajectory);
        PlanAnswer { result: Ok(trajectory), ..answer.clone() }
    };
    let spoilt = [
        ("another request", PlanAnswer { request: answer.request + 1, ..answer.clone() }),
        ("in an hour", PlanAnswer { effective: 1_800_000, ..answer.clone() }),
        ("no knots", with(|t| t.knots.clear())),
        ("not a number", with(|t| t.knots[1].q_rad[2] = f32::NAN)),
        ("infinite speed", with(|t| t.knots[1].qd_rad_s[2] = f32::INFINITY)),
        ("beyond a joint's range", with(|t| t.knots.iter_mut().for_each(|k| k.q_rad[3] = 5.0))),
        ("elsewhere", with(|t| t.knots.iter_mut().for_each(|k| k.q_rad[0] += 0.1))),
        ("backwards in time", with(|t| t.knots.iter_mut().for_each(|k| k.t_s = -k.t_s))),
        ("too fast", with(|t| t.knots.iter_mut().for_each(|k| k.t_s *= 0.1))),
    ];
    for (what, answer) in spoilt {
        let mut rig = start.clone();
        rig.send(&answer);
        let mut refused = false;
        for _ in 0..100 {
            let said = rig.sense(|_| ());
            assert_eq!(said.fault(), None, "{what}");
            refused |= said.events.iter().any(|e| matches!(e.kind, EventKind::Refused(_)));
            assert!(!said.events.iter().any(|e| matches!(e.kind, EventKind::Touch { .. })), "{what} was taken");
        }
        let ignored = what == "another request" || what == "in an hour";
        assert_eq!(refused, !ignored, "{what}: a bad trajectory counts as a refusal, so the next best is asked for");
    }
    // The same without the damage begins the touch.
    let mut rig = start;
    rig.send(&answer);
    let said = rig.sense(|_| ());
    assert!(said.events.iter().any(|e| matches!(e.kind, EventKind::Touch { .. })));
}

#[test]
fn a_command_that_is_lost_is_counted_and_does_no_harm() {
    // One in each phase, and a row of ten during the transport.
    let mut lost = 0;
    let mut phases = BTreeSet::new();
    let recording = Recording::shared();
    let mut by_tick = Vec::new();
    let mut before = None;
    recording.play(|rig, _| {
        let phase = rig.phase();
        let begins = before != Some(phase) && phases.insert(phase);
        before = Some(phase);
        let carried = phase == Phase::Transport && rig.tick() % 500 < 10;
        by_tick.push(begins || carried);
        lost += u32::from(begins || carried);
        true
    });
    let command = subject::<tactus_common::message::Command>().get();
    let mut gone = 0;
    let report = run_tampered(&options(1), move |passing, arrives| {
        let header = tactus_common::cyphal::Header::parse(passing.frame.id()).unwrap();
        let hit = by_tick.get(passing.tick as usize) == Some(&true) && gone < lost;
        if header.subject.get() == command && hit {
            gone += 1;
        } else {
            arrives.push(passing.frame);
        }
    });
    println!("{lost} commands lost in {phases:?}: {}", report.outcome_text());
    assert!(lost >= 8);
    assert_eq!(report.deadline_misses, lost, "each lost command is noticed");
    assert_eq!(report.outcome, Some(Outcome::Transported));
    assert_ne!(report.digest, recording.report.digest, "the controller felt what the robot did meanwhile");
}

#[test]
fn an_arm_that_gets_no_commands_any_more_is_noticed_by_what_it_does() {
    let command = subject::<tactus_common::message::Command>().get();
    let begins = |phase| Recording::shared().play(move |rig, _| rig.phase() != phase).tick();
    for (phase, begins) in [(Phase::Trial, begins(Phase::Trial)), (Phase::Transport, begins(Phase::Transport))] {
        let from = begins + 200;
        let report = run_tampered(&options(1), move |passing, arrives| {
            let header = tactus_common::cyphal::Header::parse(passing.frame.id()).unwrap();
            if header.subject.get() != command || passing.tick < from {
                arrives.push(passing.frame);
            }
        });
        let end = report.outcome;
        println!("{phase:?}: {end:?}, {} commands missed", report.deadline_misses);
        let expected = matches!(
            end,
            Some(Outcome::Fault(FaultReason::Tracking(_) | FaultReason::JointLimit(_) | FaultReason::JointSpeed(_)))
        );
        assert!(expected, "{phase:?}: {end:?}");
        assert_eq!(report.exit_status(), 4);
        assert!(report.deadline_misses > SILENCE_TICKS_MAX);
    }
}
