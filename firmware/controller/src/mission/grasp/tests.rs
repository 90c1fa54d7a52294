//! Promises of the grasp.

use super::*;
use crate::executor::Motion;
use crate::mission::tests::knowledge;
use crate::onset::Felt;
use crate::testing::{BOX, Desk, TRUTH};
use tactus_common::reading::HandCommand;
use tactus_common::robot::arm;

const TICKS_MAX: u32 = 20_000;

struct Rig {
    desk: Desk,
    know: Knowledge,
    grasp: Grasp,
    end: GraspEnd,
}

impl Rig {
    fn new(variant: u8) -> Self {
        let (mut desk, mut know) = (Desk::default(), knowledge());
        let plan = grasp_plan(variant, &BOX).expect("listed");
        desk.descend_to(&plan.placement.world_from_hand(&TRUTH, &BOX));
        know.store.begin_touch();
        Self { desk, know, grasp: Grasp::new(plan), end: GraspEnd::NotYet }
    }

    fn tick(&mut self) {
        let (grasp, know) = (&mut self.grasp, &mut self.know);
        self.end = self.desk.tick(|tools| grasp.step(know, tools));
    }

    fn until(&mut self, done: impl Fn(&Self) -> bool) {
        for _ in 0..TICKS_MAX {
            if done(self) {
                return;
            }
            self.tick();
        }
        panic!("{:?} {:?}", self.grasp.step, self.desk.executor.motion());
    }

    fn until_over(&mut self) -> &GraspEnd {
        self.until(|rig| !matches!(rig.end, GraspEnd::NotYet));
        &self.end
    }
}

#[test]
fn from_either_side_the_box_ends_between_the_fingers_which_push() {
    for variant in 0..2 {
        let mut rig = Rig::new(variant);
        let held = match rig.until_over() {
            GraspEnd::Held(held) => *held,
            _ => panic!("variant {variant} does not hold"),
        };
        let pushes = |m: &HandCommand| matches!(m, HandCommand::Torque(t) if *t > 0.0);
        assert!(rig.desk.hand.iter().take(FINGERS).all(pushes), "{:?}", rig.desk.hand);
        assert!(held.inner_rad.iter().all(|q| *q > OPEN_RAD && *q < CLOSED_RAD), "{held:?}");
    }
}

#[test]
fn both_sides_must_feel_the_object() {
    let pair_only = Felt { fingers: [true, true, false], palm: false, ..Felt::default() };
    let thumb_only = Felt { fingers: [false, false, true], palm: false, ..Felt::default() };
    let one_each = Felt { fingers: [true, false, true], palm: false, ..Felt::default() };
    for (felt, holds) in [(pair_only, false), (thumb_only, false), (one_each, true)] {
        let mut rig = Rig::new(0);
        rig.desk.bench.remove_object();
        rig.until(|rig| matches!(rig.grasp.step, Step::Close { .. }));
        rig.tick();
        rig.desk.felt = felt;
        rig.tick();
        rig.desk.felt = Felt::default();
        match rig.until_over() {
            GraspEnd::Held(_) => assert!(holds, "{felt:?}"),
            GraspEnd::Missed => assert!(!holds, "{felt:?}"),
            GraspEnd::Landed | GraspEnd::NotYet | GraspEnd::Stuck(_) => panic!("{felt:?}"),
        }
    }
}

#[test]
fn after_a_miss_the_hand_is_open_and_above_again() {
    let mut rig = Rig::new(0);
    rig.desk.bench.remove_object();
    rig.until(|rig| matches!(rig.grasp.step, Step::Close { .. }));
    let low_m = arm::hand_pose(&rig.desk.bench.q_rad).translation.z;
    assert!(matches!(rig.until_over(), GraspEnd::Missed));
    assert!(arm::hand_pose(&rig.desk.bench.q_rad).translation.z > low_m + 0.09);
    assert!(rig.desk.bench.hand.motor_q_rad.iter().take(FINGERS).all(|q| (q - OPEN_RAD).abs() < 0.03));
}

#[test]
fn coming_down_on_something_is_a_landing_with_evidence_and_no_finger_closes() {
    let mut rig = Rig::new(0);
    rig.desk.bench.remove_object();
    rig.until(|rig| rig.desk.executor.motion() == Motion::Guarded);
    rig.desk.felt = Felt { fingers: [false, true, false], palm: false, ..Felt::default() };
    rig.tick();
    rig.desk.felt = Felt::default();
    while matches!(rig.end, GraspEnd::NotYet) {
        rig.tick();
        assert!(!matches!(rig.grasp.step, Step::Close { .. }));
    }
    assert!(matches!(rig.end, GraspEnd::Landed));
    assert_eq!(rig.know.store.contacts().len(), 1);
}

#[test]
fn a_finger_stands_still_while_the_others_close() {
    let mut rig = Rig::new(0);
    rig.desk.bench.remove_object();
    rig.until(|rig| matches!(rig.grasp.step, Step::Close { .. }));
    rig.tick();
    rig.desk.felt = Felt { fingers: [true, false, false], palm: false, ..Felt::default() };
    rig.tick();
    rig.desk.felt = Felt::default();
    let stood_rad = rig.desk.bench.hand.motor_q_rad[0];
    while matches!(rig.grasp.step, Step::Close { .. }) {
        assert_eq!(rig.desk.hand[0], HandCommand::Velocity(0.0));
        rig.tick();
    }
    assert_eq!(rig.desk.bench.hand.motor_q_rad[0], stood_rad);
}
