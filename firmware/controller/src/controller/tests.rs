//! Promises of one tick of the whole controller.

extern crate std;

use super::*;
use crate::testing::{BOX, Bench, home, plan, readings, rollout, setup};
use proptest::prelude::*;
use std::vec::Vec;
use tactus_common::limits::SILENCE_TICKS_MAX;
use tactus_common::message::{FaultReason, Purpose};
use tactus_common::robot::ARM_LIMITS;
use tactus_common::robot::dynamics::gravity;

/// A controller at a bench: the arm stands where the reference is, the host answers within a tick.
struct Rig {
    controller: Controller,
    bench: Bench,
    tick: u32,
    plan: Option<PlanAnswer>,
    rollout: Option<RolloutResult>,
    events: Vec<Event>,
    requests: Vec<PlanRequest>,
}

impl Rig {
    fn new() -> Self {
        Self {
            controller: Controller::default(),
            bench: Bench::default(),
            tick: 0,
            plan: None,
            rollout: None,
            events: Vec::new(),
            requests: Vec::new(),
        }
    }

    /// A rig whose mission has begun at tick 0.
    fn begun() -> Self {
        let mut rig = Self::new();
        rig.setup(&setup());
        rig
    }

    fn setup(&mut self, setup: &Setup) -> Outputs {
        let readings = self.bench.readings(self.tick);
        self.feed(&Inputs { setup: Some(setup), readings: Some(readings), ..Inputs::default() })
    }

    /// A tick with these readings and the answers that have come.
    fn see(&mut self, readings: Option<JointReadings>) -> Outputs {
        let (plan, rollout) = (self.plan.take(), self.rollout.take());
        self.feed(&Inputs { readings, plan: plan.as_ref(), rollout: rollout.as_ref(), ..Inputs::default() })
    }

    /// A tick at the bench.
    fn tick(&mut self) -> Outputs {
        self.see(Some(self.bench.readings(self.tick)))
    }

    fn feed(&mut self, inputs: &Inputs) -> Outputs {
        let out = self.controller.tick(self.tick, inputs);
        if let Some(request) = &out.plan_request {
            self.requests.push(*request);
            self.plan = Some(PlanAnswer { effective: 0, request: request.request, result: plan(request, &BOX) });
        }
        if let Some(request) = &out.rollout_request {
            self.rollout = Some(rollout(request, &BOX, 0));
        }
        self.events.extend(out.events.iter().copied());
        let q_rad = self.controller.reference().map_or(self.bench.q_rad, |reference| reference.q_rad);
        self.bench.step(&q_rad, &out.commands.hand);
        self.tick += 1;
        out
    }

    fn until_phase(&mut self, phase: Phase) {
        for _ in 0..120_000 {
            if self.controller.phase() == phase {
                return;
            }
            self.tick();
        }
        panic!("{phase:?} not reached: {:?}", self.controller.outcome());
    }

    fn count(&self, kind: EventKind) -> usize {
        self.events.iter().filter(|e| e.kind == kind).count()
    }
}

fn invalid(tick: u32) -> JointReadings {
    JointReadings { valid: Validity(Validity::ALL.0 & !1), ..readings(tick, home()) }
}

fn is_limp(out: &Outputs) -> bool {
    out.commands.arm_tau_nm == [0.0; 7] && out.commands.hand == [HandCommand::Idle; HAND_MOTORS]
}

#[test]
fn without_a_mission_the_arm_is_held_where_it_stands_and_the_hand_does_nothing() {
    let mut rig = Rig::new();
    for _ in 0..200 {
        let out = rig.tick();
        let weight_nm = gravity(&home(), 0.0);
        assert!((0..7).all(|j| (out.commands.arm_tau_nm[j] - weight_nm[j]).abs() < 1e-3));
        assert_eq!(out.commands.hand, [HandCommand::Idle; HAND_MOTORS]);
    }
    assert_eq!((rig.controller.phase(), rig.controller.outcome()), (Phase::Initialise, None));
}

#[test]
fn a_whole_mission_runs_through_contact_detection_and_safety() {
    let mut rig = Rig::begun();
    rig.until_phase(Phase::Done);
    assert_eq!(rig.controller.outcome(), Some(Outcome::Transported));
    assert_eq!(rig.count(EventKind::Finished(Outcome::Transported)), 1);
    (0..100).for_each(|_| drop(rig.tick()));
    assert_eq!(rig.count(EventKind::Finished(Outcome::Transported)), 1, "told once");
    assert!(rig.events.windows(2).all(|pair| pair[0].tick <= pair[1].tick));
}

#[test]
fn the_same_inputs_give_the_same_outputs_to_the_bit_also_on_a_controller_that_was_used_before() {
    let mut fresh = Rig::begun();
    let mut used = Rig::begun();
    used.until_phase(Phase::Trial);
    (0..1_500).for_each(|_| drop(used.tick()));
    used.see(None);
    (used.bench, used.tick, used.plan, used.rollout) = (Bench::default(), 0, None, None);
    used.setup(&setup());
    for tick in 0..12_000 {
        // Debug shows every bit but the sign of a NaN, and there are no NaN.
        let (a, b) = (fresh.tick(), used.tick());
        assert_eq!(std::format!("{a:?}"), std::format!("{b:?}"), "tick {tick}");
    }
    assert!(!fresh.requests.is_empty());
}

#[test]
fn status_goes_out_ten_times_a_second() {
    let mut rig = Rig::begun();
    for tick in 1..500_u32 {
        let status = rig.tick().status;
        assert_eq!(status.is_some(), tick.is_multiple_of(STATUS_PERIOD_TICKS), "tick {tick}");
        assert!(status.is_none_or(|s| s.tick == tick && s.phase == rig.controller.phase()));
    }
}

#[test]
fn a_refused_setup_is_a_fault_with_its_reason_told_once() {
    for (bad, reason) in [
        (Setup { schema_version: [0; 8], ..setup() }, FaultReason::SchemaMismatch),
        (Setup { trials_max: 0, ..setup() }, FaultReason::BadSetup),
    ] {
        let mut rig = Rig::new();
        rig.setup(&bad);
        (0..100).for_each(|_| drop(rig.tick()));
        assert_eq!(rig.controller.outcome(), Some(Outcome::Fault(reason)));
        assert_eq!(rig.count(EventKind::Phase(Phase::Fault)), 1);
        assert_eq!(rig.count(EventKind::Finished(Outcome::Fault(reason))), 1);
        assert!(rig.requests.is_empty());
        rig.setup(&setup());
        assert_eq!(rig.controller.outcome(), None, "a good one afterwards is taken");
    }
}

#[test]
fn silence_is_bridged_for_19_ticks_and_lets_everything_go_at_the_20th() {
    let mut rig = Rig::begun();
    rig.until_phase(Phase::Trial);
    for _ in 1..SILENCE_TICKS_MAX {
        assert!(!is_limp(&rig.see(None)));
    }
    rig.tick();
    assert_eq!(rig.controller.outcome(), None, "as if nothing had been");
    (1..SILENCE_TICKS_MAX).for_each(|_| drop(rig.see(None)));
    assert!(is_limp(&rig.see(None)));
    assert!(is_limp(&rig.tick()), "and stays so when readings come again");
    assert_eq!(rig.controller.outcome(), Some(Outcome::Fault(FaultReason::HostSilent)));
}

#[test]
fn a_gap_during_a_fast_motion_is_not_taken_for_speed() {
    let mut rig = Rig::begun();
    rig.until_phase(Phase::Trial);
    // Into the middle of the approach.
    (0..200).for_each(|_| drop(rig.tick()));
    let moving = rig.controller.control.velocity_rad_s().iter().any(|v| v.abs() > 0.2);
    assert!(moving, "{:?}", rig.controller.control.velocity_rad_s());
    for _ in 0..10 {
        // The frames are lost, the arm moves on by what they would have told.
        let lost = rig.tick + 8;
        while rig.tick < lost {
            rig.controller.executor.tick();
            rig.see(None);
        }
        rig.tick();
        assert_eq!(rig.controller.outcome(), None);
    }
}

#[test]
fn a_reading_that_is_not_a_number_is_bridged_three_times_and_never_reaches_the_motors() {
    let spoils: [fn(&mut JointReadings); 2] = [|r| r.arm_q_rad[4] = f32::NAN, |r| r.tip_torque_nm[1] = f32::INFINITY];
    for spoil in spoils {
        let mut rig = Rig::begun();
        rig.until_phase(Phase::Trial);
        let mut bad = rig.bench.readings(0);
        spoil(&mut bad);
        for _ in 0..3 {
            bad.tick = rig.tick;
            let out = rig.see(Some(bad));
            assert!(out.commands.arm_tau_nm.iter().all(|t| t.is_finite()));
        }
        rig.tick();
        assert_eq!(rig.controller.outcome(), None);
        assert!(rig.controller.control.velocity_rad_s().iter().all(|v| v.is_finite()));
        (0..4).for_each(|_| drop(rig.see(Some(bad))));
        assert_eq!(rig.controller.outcome(), Some(Outcome::Fault(FaultReason::SensorInvalid)));
    }
}

#[test]
fn a_joint_out_of_range_holds_the_arm_at_rest_where_it_is() {
    let mut rig = Rig::begun();
    rig.until_phase(Phase::Trial);
    (0..200).for_each(|_| drop(rig.tick()));
    let mut out_of_range = rig.bench.readings(rig.tick);
    out_of_range.arm_q_rad[5] = ARM_LIMITS[5].upper_rad + 0.05;
    out_of_range.tick = rig.tick;
    rig.see(Some(out_of_range));
    assert_eq!(rig.controller.outcome(), Some(Outcome::Fault(FaultReason::JointLimit(5))));
    let held = *rig.controller.reference().expect("there");
    assert_eq!((held.q_rad, held.qd_rad_s), (out_of_range.arm_q_rad, [0.0; 7]));
    (0..50).for_each(|_| drop(rig.tick()));
    assert_eq!(*rig.controller.reference().expect("there"), held);
}

#[test]
fn a_fault_while_the_object_is_held_does_not_let_it_fall() {
    let mut rig = Rig::begun();
    rig.until_phase(Phase::Transport);
    (0..200).for_each(|_| drop(rig.tick()));
    let mut out_of_range = rig.bench.readings(rig.tick);
    out_of_range.arm_q_rad[0] = ARM_LIMITS[0].lower_rad - 0.05;
    rig.see(Some(out_of_range));
    for _ in 0..50 {
        let out = rig.tick();
        let pushes = |m: &HandCommand| matches!(m, HandCommand::Torque(t) if *t > 0.0);
        assert!(out.commands.hand.iter().take(3).all(pushes), "{:?}", out.commands.hand);
        assert!(!pushes(&out.commands.hand[3]));
    }
}

#[test]
fn a_fault_after_the_end_of_the_mission_still_holds_the_arm_where_it_is_measured() {
    let mut rig = Rig::begun();
    rig.until_phase(Phase::Done);
    (0..10).for_each(|_| drop(rig.tick()));
    let mut pushed = rig.bench.readings(rig.tick);
    pushed.arm_q_rad[3] += 0.2;
    rig.see(Some(pushed));
    assert!(matches!(rig.controller.outcome(), Some(Outcome::Fault(_))));
    assert_eq!(rig.controller.reference().expect("there").q_rad, pushed.arm_q_rad);
}

#[test]
fn a_host_that_does_not_answer_ends_in_a_fault_with_the_arm_held() {
    let mut rig = Rig::begun();
    while rig.controller.outcome().is_none() {
        rig.plan = None;
        rig.tick();
        assert!(rig.tick < 10_000, "waits for ever");
    }
    assert_eq!(rig.controller.outcome(), Some(Outcome::Fault(FaultReason::HostSlow)));
    assert!(!is_limp(&rig.tick()));
    assert!(rig.requests.iter().all(|r| r.purpose == Purpose::Touch));
}

#[test]
fn missing_readings_at_the_very_beginning_command_nothing() {
    let mut rig = Rig::new();
    assert!(is_limp(&rig.see(None)));
    assert!(is_limp(&rig.see(Some(invalid(1)))));
    assert!(!is_limp(&rig.tick()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_the_readings_torques_and_hand_commands_are_finite_and_within_limits(
        numbers in prop::collection::vec((any::<u32>(), prop::num::f32::ANY, any::<u32>()), 1..60), begin in any::<bool>(),
    ) {
        let mut controller = Controller::default();
        let mission = setup();
        for (i, (tick, value, bits)) in numbers.iter().enumerate() {
            let mut r = readings(*tick, home());
            r.valid = Validity(if bits & 1 == 0 { Validity::ALL.0 } else { *bits });
            match bits >> 1 & 7 {
                0 => r.arm_q_rad[(bits >> 8) as usize % 7] = *value,
                1 => r.motor_q_rad[(bits >> 8) as usize % 4] = *value,
                2 => r.inner_q_rad[(bits >> 8) as usize % 3] = *value,
                3 => r.effort_nm[(bits >> 8) as usize % 4] = *value,
                4 => r.tip_torque_nm[(bits >> 8) as usize % 3] = *value,
                _ => {}
            }
            let readings = (bits >> 5 & 7 > 0).then_some(r);
            let setup = (begin && i == 0).then_some(&mission);
            let out = controller.tick(*tick, &Inputs { setup, readings, ..Inputs::default() });
            for (j, tau_nm) in out.commands.arm_tau_nm.iter().enumerate() {
                prop_assert!(tau_nm.abs() <= ARM_LIMITS[j].torque_nm, "J{}: {tau_nm}", j + 1);
            }
            for command in out.commands.hand {
                let value = match command {
                    HandCommand::Idle => 0.0,
                    HandCommand::Position(v) | HandCommand::Velocity(v) | HandCommand::Torque(v) => v,
                };
                prop_assert!(value.is_finite());
            }
        }
    }
}
