//! Promises of the mission: which phase follows which, against a scripted host and a bench instead of a world.

extern crate std;

use super::enquiry::{ANSWER_TICKS_MAX, REPEAT_TICKS};
use super::foresight::CONFIRM_RAD;
use super::knowledge::SETUP_MAX;
use super::*;
use crate::testing::{BOX, Desk, TRUTH, plan, pressed_across, rollout, setup};
use core::mem::size_of;
use std::vec::Vec;
use tactus_common::limits::PAD_PERIOD_TICKS;
use tactus_common::message::{PlanAnswer, PlanRequest, RolloutRequest, RolloutResult, SCHEMA_VERSION};
use tactus_common::pose::{Interval, wrap};
use tactus_common::shape::{ObjectShape, Obstacle};
use tactus_common::trajectory::Trajectory;

/// A touch takes 5,000 ticks at most on this bench; missions that take longer than this hang.
const TICKS_MAX: u32 = 120_000;

/// What the host says to a plan request.
type Planner = fn(&PlanRequest) -> Option<Result<Trajectory, RefusalReason>>;

fn willing(request: &PlanRequest) -> Option<Result<Trajectory, RefusalReason>> {
    Some(plan(request, &BOX))
}

/// What a mission knows before its first touch.
pub(super) fn knowledge() -> Knowledge {
    let mut mission = Mission::default();
    mission.begin(&setup()).expect("a set-up that makes sense");
    mission.knowledge
}

/// A mission with a host.
struct Rig {
    mission: Mission,
    desk: Desk,
    planner: Planner,
    /// Foretells what a touch would feel; `None`: stays silent.
    mental: fn(&RolloutRequest) -> Option<RolloutResult>,
    plan: Option<PlanAnswer>,
    rollout: Option<RolloutResult>,
    requests: Vec<PlanRequest>,
    events: Vec<EventKind>,
    payload_kg_max: f32,
}

impl Rig {
    fn new(setup: &Setup) -> Self {
        let mut mission = Mission::default();
        mission.begin(setup).expect("a set-up that makes sense");
        Self {
            mission,
            desk: Desk::default(),
            planner: willing,
            mental: |request| Some(rollout(request, &BOX, 0)),
            plan: None,
            rollout: None,
            requests: Vec::new(),
            events: Vec::new(),
            payload_kg_max: 0.0,
        }
    }

    fn tick(&mut self) {
        let (plan, rollout) = (self.plan.take(), self.rollout.take());
        let mission = &mut self.mission;
        self.desk.answer(plan.as_ref(), rollout.as_ref(), |tools| mission.step(tools));
        let out = &self.desk.out;
        if let Some(request) = out.plan_request {
            self.requests.push(request);
            let result = (self.planner)(&request);
            self.plan = result.map(|result| PlanAnswer { effective: 0, request: request.request, result });
        }
        if let Some(request) = &out.rollout_request {
            self.rollout = (self.mental)(request);
        }
        self.events.extend(out.events.iter().map(|e| e.kind));
        self.payload_kg_max = self.payload_kg_max.max(self.mission.payload_kg());
    }

    /// Ticks until `done`.
    fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) -> u32 {
        for tick in 0..TICKS_MAX {
            if done(self) {
                return tick;
            }
            self.tick();
        }
        panic!("{what}: still {:?} after {TICKS_MAX} ticks; {:?}", self.mission.phase(), self.mission.outcome());
    }

    fn until_phase(&mut self, phase: Phase) {
        self.until("phase", |rig| rig.mission.phase() == phase);
    }

    fn outcome(&mut self) -> Outcome {
        self.until("outcome", |rig| rig.mission.outcome().is_some());
        self.mission.outcome().expect("just seen")
    }

    fn phases(&self) -> Vec<Phase> {
        self.events.iter().filter_map(|e| if let EventKind::Phase(p) = e { Some(*p) } else { None }).collect()
    }

    fn count(&self, wanted: impl Fn(&EventKind) -> bool) -> usize {
        self.events.iter().filter(|e| wanted(e)).count()
    }

    fn touches(&self) -> usize {
        self.count(|e| matches!(e, EventKind::Touch { .. }))
    }
}

#[test]
fn what_changes_hands_with_the_phase_is_small() {
    assert!(size_of::<Doing>() <= 256, "{} bytes are moved when a phase begins", size_of::<Doing>());
}

#[test]
fn a_box_is_touched_found_grasped_carried_and_set_down() {
    let mut rig = Rig::new(&setup());
    assert_eq!(rig.outcome(), Outcome::Transported);
    let phases = rig.phases();
    assert_eq!(phases.first(), Some(&Phase::Plan));
    assert!(phases.ends_with(&[Phase::Grasp, Phase::Transport, Phase::Release, Phase::Done]), "{phases:?}");
    for pair in phases.windows(2) {
        let allowed: &[Phase] = match pair[0] {
            Phase::Plan => &[Phase::Trial],
            Phase::Trial => &[Phase::Update],
            Phase::Update => &[Phase::Plan, Phase::Grasp],
            Phase::Grasp => &[Phase::Transport, Phase::Update],
            Phase::Transport => &[Phase::Release],
            _ => &[Phase::Done],
        };
        assert!(allowed.contains(&pair[1]), "{pair:?}");
    }
    // The belief of the last update before the grasp, 3 mm and 1.5 degrees as the grasp needs it.
    let believed = rig.requests.iter().rfind(|r| r.purpose == Purpose::Grasp).expect("a grasp was asked for").belief;
    assert!((believed.x_m - TRUTH.x_m).abs() < 3e-3 && (believed.y_m - TRUTH.y_m).abs() < 3e-3, "{believed:?}");
    assert!(wrap(believed.phi_rad - TRUTH.phi_rad, core::f32::consts::PI).abs() < 0.026, "{believed:?}");
    let object = rig.desk.bench.object.expect("the box is there");
    assert!((object.x_m - TRUTH.x_m + 0.5).abs() < 2e-3 && (object.y_m - TRUTH.y_m).abs() < 2e-3, "{object:?}");
    assert!((rig.payload_kg_max - setup().mass_kg).abs() < 1e-3, "the arm knows what it carries");
    assert_eq!(rig.mission.payload_kg(), 0.0, "and that it has set it down");
}

#[test]
fn every_request_starts_where_the_arm_stands_and_has_a_new_number() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| {
        let stands = r.start_q_rad.iter().all(|q| q.is_finite());
        assert!(stands && r.belief.is_finite() && r.covariance.iter().all(|c| c.is_finite()));
        willing(r)
    };
    rig.outcome();
    assert!(rig.requests.windows(2).all(|pair| pair[1].request > pair[0].request));
    let touches = rig.requests.iter().filter(|r| r.purpose == Purpose::Touch);
    assert!(touches.clone().all(|r| r.touch < crate::touch::CANDIDATES));
    assert!(rig.requests.iter().filter(|r| r.purpose != Purpose::Touch).all(|r| r.touch == u8::MAX));
}

#[test]
fn a_refused_touch_is_followed_by_the_next_best_one() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| if r.request < 3 { Some(Err(RefusalReason::GoalInCollision)) } else { willing(r) };
    rig.until_phase(Phase::Trial);
    let asked: Vec<u8> = rig.requests.iter().map(|r| r.touch).collect();
    assert_eq!(asked.len(), 3);
    assert!(asked[0] != asked[1] && asked[1] != asked[2] && asked[0] != asked[2], "{asked:?}");
    assert_eq!(rig.count(|e| *e == EventKind::Refused(RefusalReason::GoalInCollision)), 2);
    let EventKind::Touch { candidate, .. } = rig.events[rig.events.len() - 2] else { panic!("{:?}", rig.events) };
    assert_eq!(candidate, asked[2], "the touch that is made is the one that was granted");
}

#[test]
fn if_every_touch_is_refused_the_mission_fails_with_the_last_reason() {
    let mut rig = Rig::new(&setup());
    rig.planner = |_| Some(Err(RefusalReason::NoPath));
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NoPlan(RefusalReason::NoPath)));
    assert_eq!(rig.requests.len(), usize::from(crate::touch::CANDIDATES), "each was tried once");
    rig.tick();
    assert_eq!((rig.mission.phase(), rig.mission.fault()), (Phase::Failed, None));
}

#[test]
fn a_trajectory_that_the_executor_cannot_take_counts_as_refused() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| {
        let mut away = *r;
        away.start_q_rad[0] += 0.5;
        Some(plan(&away, &BOX))
    };
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NoPlan(RefusalReason::NoPath)));
}

#[test]
fn an_answer_to_another_request_is_not_taken() {
    let mut rig = Rig::new(&setup());
    rig.planner = |_| None;
    rig.until("request", |rig| !rig.requests.is_empty());
    let request = rig.requests[0];
    let stale = PlanRequest { request: request.request.wrapping_sub(1), ..request };
    rig.plan = Some(PlanAnswer { effective: 0, request: stale.request, result: plan(&stale, &BOX) });
    (0..10).for_each(|_| rig.tick());
    assert_eq!(rig.mission.phase(), Phase::Plan);
    rig.plan = Some(PlanAnswer { effective: 0, request: request.request, result: plan(&request, &BOX) });
    rig.tick();
    assert_eq!(rig.mission.phase(), Phase::Trial);
}

#[test]
fn a_host_that_answers_no_plan_request_is_a_fault_after_the_time_for_answers() {
    let mut rig = Rig::new(&setup());
    rig.planner = |_| None;
    rig.until("request", |rig| !rig.requests.is_empty());
    for _ in 0..ANSWER_TICKS_MAX {
        rig.tick();
    }
    assert_eq!(rig.mission.fault(), None, "not one tick early");
    rig.tick();
    assert_eq!(rig.mission.fault(), Some(FaultReason::HostSlow));
}

#[test]
fn a_question_that_is_lost_is_put_again_under_its_number_and_the_mission_goes_on() {
    let mut rig = Rig::new(&setup());
    rig.planner = |_| None;
    rig.until("request", |rig| !rig.requests.is_empty());
    let asked = rig.requests[0];
    for repeats in 1..=2 {
        rig.until("repeat", |rig| rig.requests.len() > repeats);
        assert_eq!(rig.requests[repeats], asked);
    }
    rig.planner = willing;
    assert_eq!(rig.outcome(), Outcome::Transported);
}

#[test]
fn a_rollout_that_is_lost_is_asked_for_again() {
    let mut rig = Rig::new(&setup());
    rig.mental = |_| None;
    let asked = |rig: &Rig| rig.desk.out.rollout_request;
    rig.until("rollout", |rig| asked(rig).is_some());
    let first = asked(&rig);
    rig.tick();
    assert_eq!(rig.until("repeat", |rig| asked(rig).is_some()), REPEAT_TICKS - 1);
    assert_eq!(asked(&rig), first);
}

#[test]
fn a_finger_that_never_reaches_its_shape_is_a_fault_that_names_it() {
    for purpose in [Purpose::Touch, Purpose::Grasp] {
        let mut rig = Rig::new(&setup());
        rig.until("motion", |rig| rig.requests.last().is_some_and(|r| r.purpose == purpose));
        let mut ticks = 0;
        while rig.mission.fault().is_none() {
            rig.tick();
            // F2 hangs.
            rig.desk.bench.hand.motor_q_rad[1] = 1.0;
            ticks += 1;
            assert!(ticks < 10_000, "{purpose:?}: {:?}", rig.mission.phase());
        }
        assert_eq!(rig.mission.fault(), Some(FaultReason::Tracking(8)), "{purpose:?}");
        assert_eq!(rig.desk.executor.motion(), crate::executor::Motion::AtGuard, "it did not come down");
    }
}

#[test]
fn a_mental_world_that_does_not_answer_is_a_fault_too() {
    let mut rig = Rig::new(&setup());
    rig.mental = |_| None;
    rig.until("fault", |rig| rig.mission.fault().is_some());
    assert_eq!((rig.mission.fault(), rig.mission.phase()), (Some(FaultReason::HostSlow), Phase::Update));
}

#[test]
fn a_belief_that_the_mental_world_contradicts_is_tested_by_another_touch() {
    let mut rig = Rig::new(&setup());
    rig.mental = |request| {
        let mut result = rollout(request, &BOX, 0);
        for onset in result.onset_inner_rad.iter_mut().flatten() {
            *onset += 2.0 * CONFIRM_RAD;
        }
        Some(result)
    };
    rig.until("refutation", |rig| rig.count(|e| *e == EventKind::Confirmed(false)) > 0);
    let touches = rig.touches();
    rig.until("touch", |rig| rig.touches() > touches);
}

#[test]
fn nothing_is_touched_more_often_than_allowed_and_nothing_felt_is_a_failure() {
    for trials_max in [1, 3] {
        let mut rig = Rig::new(&Setup { trials_max, ..setup() });
        rig.desk.bench.remove_object();
        assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NothingFelt));
        assert_eq!(rig.touches(), usize::from(trials_max));
    }
}

#[test]
fn one_touch_that_leaves_the_pose_open_is_not_enough_to_grasp() {
    let mut rig =
        Rig::new(&Setup { trials_max: 1, interval: Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 }, ..setup() });
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NotConfident));
    assert_eq!(rig.requests.iter().filter(|r| r.purpose != Purpose::Touch).count(), 0);
}

#[test]
fn refused_grasps_are_tried_from_the_other_side_and_then_fail() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| if r.purpose == Purpose::Grasp { Some(Err(RefusalReason::OutOfReach)) } else { willing(r) };
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NoPlan(RefusalReason::OutOfReach)));
    let grasps: Vec<&PlanRequest> = rig.requests.iter().filter(|r| r.purpose == Purpose::Grasp).collect();
    assert_eq!(grasps.len(), 2);
    assert_ne!(grasps[0].placement, grasps[1].placement);
}

#[test]
fn a_refused_transport_fails_with_the_reason() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| if r.purpose == Purpose::Transport { Some(Err(RefusalReason::NoPath)) } else { willing(r) };
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NoPlan(RefusalReason::NoPath)));
}

#[test]
fn fingers_that_close_on_nothing_lead_back_to_the_update_and_in_the_end_to_failure() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| willing(r);
    rig.until("grasp", |rig| rig.mission.phase() == Phase::Grasp);
    rig.desk.bench.remove_object();
    rig.until("end of the grasp", |rig| rig.mission.phase() != Phase::Grasp);
    assert_eq!(rig.mission.phase(), Phase::Update);
    // Nothing is there any more: whatever happens then, the mission ends, and not well.
    assert!(matches!(rig.outcome(), Outcome::Failed(_)));
}

/// Loses the object on the way; the mission is about to search for it anew.
fn lose(rig: &mut Rig) {
    rig.until_phase(Phase::Transport);
    let from = rig.desk.bench.object.expect("held");
    rig.until("on the way", |rig| rig.desk.bench.object.is_some_and(|o| o.x_m < from.x_m - 0.15));
    rig.desk.bench.remove_object();
    rig.until("loss", |rig| rig.mission.phase() != Phase::Transport);
}

/// Puts the object on the table once the hand is open: a little off the place where it was lost first.
fn fall(rig: &mut Rig) {
    rig.until("way up", |rig| rig.requests.last().is_some_and(|r| r.purpose == Purpose::Retreat));
    let fallen = PlanarPose { x_m: TRUTH.x_m - 0.18, y_m: TRUTH.y_m + 0.02, phi_rad: TRUTH.phi_rad + 0.1 };
    rig.desk.bench.object = Some(fallen);
}

#[test]
fn an_object_lost_on_the_way_is_searched_for_below_the_hand_and_brought_to_the_same_goal() {
    let mut rig = Rig::new(&setup());
    rig.until_phase(Phase::Transport);
    let goal = rig.requests.last().map(|r| (r.belief.x_m + r.displacement_m[0], r.belief.y_m + r.displacement_m[1]));
    lose(&mut rig);
    fall(&mut rig);
    let touches = rig.touches();
    assert_eq!(rig.outcome(), Outcome::Transported);
    assert!(rig.touches() > touches);
    let (object, goal) = (rig.desk.bench.object.expect("found"), goal.expect("there was a transport"));
    assert!((object.x_m - goal.0).abs() < 3e-3 && (object.y_m - goal.1).abs() < 3e-3, "{object:?} {goal:?}");
}

#[test]
fn an_object_that_slips_is_taken_anew_harder_and_carried_to_the_same_goal() {
    let mut rig = Rig::new(&setup());
    rig.until_phase(Phase::Transport);
    (0..150).for_each(|_| rig.tick());
    for step in 0..10 {
        rig.desk.images = pressed_across(step as f32 / 9.0);
        (0..PAD_PERIOD_TICKS).for_each(|_| rig.tick());
    }
    assert_eq!(rig.count(|e| matches!(e, EventKind::Slip { finger: 0, .. })), 1, "{:?}", rig.events);
    let touches = rig.touches();
    assert_eq!(rig.outcome(), Outcome::Transported);
    assert_eq!(rig.touches(), touches, "it need not be searched for");
    let object = rig.desk.bench.object.expect("the box is there");
    assert!((object.x_m - TRUTH.x_m + 0.5).abs() < 3e-3 && (object.y_m - TRUTH.y_m).abs() < 3e-3, "{object:?}");
}

#[test]
fn an_object_lost_too_often_ends_the_mission_with_the_arm_at_rest() {
    let mut rig = Rig::new(&setup());
    for _ in 0..LOSSES_MAX {
        lose(&mut rig);
        fall(&mut rig);
    }
    lose(&mut rig);
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::ObjectLost));
    assert_eq!((rig.mission.phase(), rig.mission.payload_kg()), (Phase::Failed, 0.0));
    assert_eq!(rig.desk.executor.motion(), crate::executor::Motion::Holding);
}

#[test]
fn after_a_loss_a_refused_way_up_ends_the_mission() {
    let mut rig = Rig::new(&setup());
    rig.planner =
        |r| if r.purpose == Purpose::Retreat { Some(Err(RefusalReason::StartInCollision)) } else { willing(r) };
    lose(&mut rig);
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::ObjectLost));
}

#[test]
fn a_touch_without_a_guarded_part_and_a_retreat_with_one_are_refused() {
    let mut rig = Rig::new(&setup());
    rig.planner = |r| Some(plan(r, &BOX).map(|t| Trajectory { guarded_from: u8::MAX, ..t }));
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::NoPlan(RefusalReason::NoPath)));
    let mut rig = Rig::new(&setup());
    rig.planner = |r| {
        let guard = |t: Trajectory| if r.purpose == Purpose::Retreat { Trajectory { guarded_from: 0, ..t } } else { t };
        Some(plan(r, &BOX).map(guard))
    };
    lose(&mut rig);
    assert_eq!(rig.outcome(), Outcome::Failed(FailureReason::ObjectLost));
}

#[test]
fn a_setup_of_another_schema_is_refused() {
    let other = Setup { schema_version: (SCHEMA_VERSION ^ 1).to_le_bytes(), ..setup() };
    assert_eq!(Mission::default().begin(&other), Err(FaultReason::SchemaMismatch));
}

#[test]
fn a_setup_that_makes_no_sense_is_refused_and_nothing_begins() {
    let cases: [fn(&mut Setup); 23] = [
        |s| s.shape = ObjectShape::Cylinder { radius_m: 0.0, half_height_m: 0.1 },
        |s| s.obstacles[3] = Some(Obstacle { shape: ObjectShape::Sphere { radius_m: -0.1 }, pose: s.guess }),
        |s| s.obstacles[0] = Some(Obstacle { shape: s.shape, pose: PlanarPose::new(f32::NAN, 0.0, 0.0) }),
        |s| s.guess.x_m = 1e30,
        |s| s.interval.phi_rad = f32::MAX,
        |s| s.displacement_m[0] = -11.0,
        |s| s.shape = ObjectShape::Cuboid { half_extents_m: [0.1, 0.1, 1e20] },
        |s| s.guess.x_m = f32::NAN,
        |s| s.guess.phi_rad = f32::INFINITY,
        |s| s.interval.x_m = -0.01,
        |s| s.interval.y_m = f32::NAN,
        |s| s.interval.phi_rad = f32::INFINITY,
        |s| s.displacement_m[1] = f32::NAN,
        |s| s.mass_kg = -0.1,
        |s| s.mass_kg = f32::NAN,
        |s| s.mass_kg = 10.1,
        |s| s.trials_max = 0,
        |s| s.robot_base.phi_rad = f32::NAN,
        |s| s.robot_base.x_m = 10.5,
        |s| s.shape = ObjectShape::Cuboid { half_extents_m: [0.1, 0.0, 0.1] },
        |s| s.shape = ObjectShape::Cuboid { half_extents_m: [0.1, f32::NAN, 0.1] },
        |s| s.shape = ObjectShape::Cuboid { half_extents_m: [0.1, 0.1, f32::INFINITY] },
        |s| s.shape = ObjectShape::Cuboid { half_extents_m: [-0.1, 0.1, 0.1] },
    ];
    for (i, spoil) in cases.iter().enumerate() {
        let mut bad = setup();
        spoil(&mut bad);
        let mut mission = Mission::default();
        assert_eq!(mission.begin(&bad), Err(FaultReason::BadSetup), "case {i}");
        let mut desk = Desk::default();
        desk.tick(|tools| mission.step(tools));
        assert_eq!((mission.phase(), mission.believed()), (Phase::Initialise, None), "case {i}");
    }
}

#[test]
fn setups_at_the_edge_of_sense_neither_panic_nor_hang() {
    let cases: [fn(&mut Setup); 5] = [
        |s| s.guess.x_m = SETUP_MAX,
        |s| s.guess.phi_rad = -SETUP_MAX,
        |s| s.interval = Interval { x_m: SETUP_MAX, y_m: SETUP_MAX, phi_rad: SETUP_MAX },
        |s| s.interval = Interval::default(),
        |s| s.shape = ObjectShape::Cuboid { half_extents_m: [1e-20, SETUP_MAX, SETUP_MAX] },
    ];
    for spoil in cases {
        let mut odd = Setup { trials_max: 1, ..setup() };
        spoil(&mut odd);
        let mut mission = Mission::default();
        mission.begin(&odd).expect("odd, but possible");
        let mut rig = Rig { mission, ..Rig::new(&setup()) };
        rig.desk.bench.remove_object();
        rig.planner = |r| if r.belief.is_finite() { willing(r) } else { Some(Err(RefusalReason::NonFinite)) };
        assert!(matches!(rig.outcome(), Outcome::Failed(_)));
    }
}

#[test]
fn a_new_setup_forgets_the_mission_before_it() {
    let mut rig = Rig::new(&setup());
    rig.until_phase(Phase::Update);
    rig.mission.begin(&setup()).expect("sound");
    let status = rig.mission.status(1, rig.mission.phase());
    assert_eq!((status.phase, status.touches, status.evidence), (Phase::Initialise, 0, 0));
    assert_eq!(status.belief, setup().guess);
}
