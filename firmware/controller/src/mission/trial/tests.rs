//! Promises of one touch.

extern crate std;

use super::*;
use crate::executor::Motion;
use crate::mission::closing;
use crate::mission::tests::knowledge;
use crate::onset::Felt;
use crate::testing::{BOX, Desk, TRUTH};
use crate::touch::candidate;
use std::vec::Vec;
use tactus_common::limits::PADS;
use tactus_common::pose::PlanarPose;
use tactus_common::reading::JointReadings;
use tactus_common::robot::arm;
use tactus_common::shape::{ObjectShape, Obstacle};

/// Longer than any touch.
const TICKS_MAX: u32 = 20_000;

/// A touch of the box that stands where it is aimed at, unless the desk is told otherwise.
struct Rig {
    desk: Desk,
    know: Knowledge,
    trial: Trial,
    events: Vec<EventKind>,
    end: Option<[Option<f32>; FINGERS]>,
}

impl Rig {
    fn new(id: u8, aim: &PlanarPose) -> Self {
        let plan = candidate(id, &BOX).expect("listed");
        let (mut desk, mut know) = (Desk::default(), knowledge());
        desk.descend_to(&plan.world_from_hand(aim, &BOX));
        know.store.begin_touch();
        Self { desk, know, trial: Trial::new(&plan), events: Vec::new(), end: None }
    }

    fn tick(&mut self) {
        let (trial, know) = (&mut self.trial, &mut self.know);
        if let TrialEnd::Over { onset_inner_rad, .. } = self.desk.tick(|tools| trial.step(know, tools)) {
            self.end = Some(onset_inner_rad);
        }
        self.events.extend(self.desk.out.events.iter().map(|e| e.kind));
    }

    fn until(&mut self, done: impl Fn(&Self) -> bool) {
        for _ in 0..TICKS_MAX {
            if done(self) {
                return;
            }
            self.tick();
        }
        panic!("{:?} {:?}", self.trial.step, self.desk.executor.motion());
    }

    fn until_over(&mut self) -> [Option<f32>; FINGERS] {
        self.until(|rig| rig.end.is_some());
        self.end.expect("over")
    }

    fn height_m(&self) -> f32 {
        arm::hand_pose(&self.desk.bench.q_rad).translation.z
    }
}

#[test]
fn a_finger_that_a_known_obstacle_may_have_stopped_stands_still_and_is_no_evidence() {
    let mut rig = Rig::new(0, &TRUTH);
    // A slab whose outer side is the object's on the side of F3: what F3 feels may be either.
    let shape = ObjectShape::Cuboid { half_extents_m: [0.1, 0.02, 0.1] };
    let pose = TRUTH.compose(&PlanarPose::new(0.0, -0.03, 0.0));
    rig.know.setup.obstacles[1] = Some(Obstacle { shape, pose });
    let onsets = rig.until_over();
    assert!(onsets[0].is_some() && onsets[1].is_some() && onsets[2].is_none(), "{onsets:?}");
    assert_eq!(rig.trial.plan().closes, [true, true, false], "what is made of the touch leaves F3 out");
    assert_eq!(rig.know.store.contacts().len(), 2);
    let thumb = |e: &EventKind| matches!(e, EventKind::Contact { finger: 2, descending: false, .. });
    assert!(rig.events.iter().any(thumb), "that it felt something is told all the same");
}

#[test]
fn every_finger_of_the_touch_stops_where_it_feels_the_object_and_is_evidence() {
    let mut rig = Rig::new(0, &TRUTH);
    let onsets = rig.until_over();
    assert!(onsets.iter().all(Option::is_some), "{onsets:?}");
    let contacts = rig.know.store.contacts();
    assert_eq!(contacts.len(), FINGERS);
    assert!(contacts.iter().all(|c| c.kind == ContactKind::Closing));
    assert!(!rig.know.store.free().is_empty(), "what was free before the closing is known");
    for (finger, onset) in onsets.iter().enumerate() {
        let told = rig.events.iter().any(|e| {
            matches!(e, EventKind::Contact { finger: f, inner_rad, descending: false }
                if usize::from(*f) == finger && Some(*inner_rad) == *onset)
        });
        assert!(told, "F{}: {:?}", finger + 1, rig.events);
    }
}

#[test]
fn a_finger_that_felt_something_goes_no_further_until_all_open() {
    // Off the middle, so that one side touches well before the other.
    let mut rig = Rig::new(0, &PlanarPose { y_m: TRUTH.y_m + 0.01, ..TRUTH });
    let mut stood: [Option<f32>; FINGERS] = [None; FINGERS];
    while rig.end.is_none() {
        let onset = match &rig.trial.step {
            Step::Close(closing) => closing.onset_inner_rad(),
            _ => [None; FINGERS],
        };
        rig.tick();
        for f in 0..FINGERS {
            if let Some(onset_rad) = onset[f].filter(|_| matches!(rig.trial.step, Step::Close { .. })) {
                let further_rad = rig.desk.bench.hand.motor_q_rad[f] - onset_rad;
                assert!(further_rad.abs() < 2e-3, "F{} went on by {further_rad}", f + 1);
                stood[f] = Some(onset_rad);
            }
        }
    }
    assert!(stood.iter().any(Option::is_some), "the first one waited for the last");
}

#[test]
fn fingers_that_the_touch_does_not_close_stay_open() {
    let mut rig = Rig::new(8, &TRUTH);
    let plan = *rig.trial.plan();
    assert_eq!(plan.closes, [false, false, true]);
    let mut widest = 0.0_f32;
    rig.until(|rig| matches!(rig.trial.step, Step::Close { .. }));
    while rig.end.is_none() {
        rig.tick();
        let [f1, f2, _, _] = rig.desk.bench.hand.motor_q_rad;
        widest = widest.max((f1 - plan.preopen_rad[0]).abs()).max((f2 - plan.preopen_rad[1]).abs());
    }
    assert!(widest < 0.02, "{widest}");
    assert!(rig.end.is_some_and(|onsets| onsets[0].is_none() && onsets[1].is_none() && onsets[2].is_some()));
}

#[test]
fn without_an_object_the_fingers_sweep_free_and_that_is_evidence_too() {
    let mut rig = Rig::new(0, &TRUTH);
    rig.desk.bench.remove_object();
    assert_eq!(rig.until_over(), [None; FINGERS]);
    assert!(rig.know.store.contacts().is_empty());
    assert!(rig.know.store.free().len() > FINGERS, "the way of each finger is known to be free");
    assert!(rig.events.iter().all(|e| !matches!(e, EventKind::Contact { .. })));
}

#[test]
fn coming_down_on_the_object_stops_the_hand_before_any_finger_closes() {
    // The open tips hang 135 mm from the hand's axis: aimed 110 mm off, one side comes down 25 mm inside the top face.
    let aim = PlanarPose { y_m: TRUTH.y_m + 0.11, ..TRUTH };
    let mut rig = Rig::new(0, &aim);
    rig.until(|rig| rig.desk.executor.motion() == Motion::Stopping);
    let height_m = rig.height_m();
    assert!(rig.events.iter().any(|e| matches!(e, EventKind::Contact { descending: true, .. })));
    let mut lowest_m = height_m;
    while rig.end.is_none() {
        rig.tick();
        assert!(!matches!(rig.trial.step, Step::Close { .. }));
        lowest_m = lowest_m.min(rig.height_m());
    }
    assert!(height_m - lowest_m < 2e-3, "went {} m further", height_m - lowest_m);
    assert!(rig.height_m() > lowest_m + 0.02, "and the hand is above again");
    assert_eq!(rig.end, Some([None; FINGERS]), "nothing was felt while closing");
    let contacts = rig.know.store.contacts();
    assert!(!contacts.is_empty() && contacts.iter().all(|c| c.kind == ContactKind::Landing));
}

#[test]
fn a_palm_that_feels_something_on_the_way_down_ends_the_touch_as_well() {
    let mut rig = Rig::new(0, &TRUTH);
    rig.desk.bench.remove_object();
    rig.until(|rig| rig.desk.executor.motion() == Motion::Guarded);
    rig.desk.felt = Felt { palm: true, ..Felt::default() };
    rig.tick();
    rig.desk.felt = Felt::default();
    rig.until_over();
    assert_eq!(rig.know.store.contacts().len(), 1);
    assert!(rig.events.contains(&EventKind::Contact { finger: FINGERS as u8, inner_rad: 0.0, descending: true }));
}

#[test]
fn what_is_felt_on_the_way_to_the_place_above_is_not_evidence() {
    let mut rig = Rig::new(0, &TRUTH);
    rig.desk.bench.remove_object();
    rig.desk.felt = Felt { fingers: [true; FINGERS], palm: false, ..Felt::default() };
    rig.until(|rig| rig.desk.executor.motion() == Motion::AtGuard);
    rig.desk.felt = Felt::default();
    rig.until_over();
    assert!(rig.know.store.contacts().is_empty());
}

#[test]
fn what_fingers_felt_before_they_were_free_stops_no_approach() {
    let mut rig = Rig::new(0, &TRUTH);
    // An object that is torn out of the hand drags at the tips; free again, they seem to push for ever.
    let free = rig.desk.bench.readings(0);
    let dragged = JointReadings { tip_torque_nm: free.tip_torque_nm.map(|free_nm| free_nm - 0.2), ..free };
    (0..500).for_each(|_| assert!(!rig.desk.onset.feel(&dragged, &[None; PADS]).any()));
    (0..5_000).for_each(|_| assert_eq!(rig.desk.onset.feel(&free, &[None; PADS]).knocked, [true; FINGERS]));
    while rig.desk.executor.motion() == Motion::Travelling {
        rig.tick();
        rig.desk.felt = rig.desk.onset.feel(&free, &[None; PADS]);
    }
    assert_eq!(rig.desk.executor.motion(), Motion::AtGuard, "it arrived above");
    rig.desk.felt = Felt::default();
    let onsets = rig.until_over();
    assert!(onsets.iter().all(Option::is_some), "{onsets:?}");
    assert!(rig.know.store.contacts().iter().all(|c| c.kind == ContactKind::Closing));
}

#[test]
fn the_hand_does_not_come_down_before_the_fingers_have_their_shape() {
    let mut rig = Rig::new(6, &TRUTH);
    rig.until(|rig| rig.desk.executor.motion() == Motion::Guarded);
    let plan = rig.trial.plan();
    let [f1, f2, f3, spread] = rig.desk.bench.hand.motor_q_rad;
    for (q_rad, wanted) in
        [(f1, plan.preopen_rad[0]), (f2, plan.preopen_rad[1]), (f3, plan.preopen_rad[2]), (spread, plan.spread_rad)]
    {
        assert!((q_rad - wanted).abs() < 0.021, "{q_rad} {wanted}");
    }
}

#[test]
fn a_finger_that_never_arrives_anywhere_ends_the_closing_after_its_time() {
    let mut rig = Rig::new(0, &TRUTH);
    rig.desk.bench.remove_object();
    rig.until(|rig| matches!(rig.trial.step, Step::Close { .. }));
    let mut ticks = 0;
    while matches!(rig.trial.step, Step::Close { .. }) {
        rig.tick();
        // Jammed.
        rig.desk.bench.hand.motor_q_rad[1] = 0.5;
        ticks += 1;
        assert!(ticks <= closing::TICKS_MAX + 1);
    }
}
