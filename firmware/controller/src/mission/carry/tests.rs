//! Promises of the carrying.

extern crate std;

use super::*;
use crate::onset::Felt;
use crate::testing::{Desk, home, pressed_across, through};
use nalgebra::Vector3;
use std::vec::Vec;
use tactus_common::limits::PAD_PERIOD_TICKS;
use tactus_common::message::Event;
use tactus_common::robot::FINGERTIP_TAXELS;

const MASS_KG: f32 = 0.6;
const TICKS_MAX: u32 = 20_000;

struct Rig {
    desk: Desk,
    carry: Carry,
    slip: Slip,
    slips: usize,
    end: CarryEnd,
}

impl Rig {
    /// Fingers at one radian around nothing that the bench knows of: they stand where the test puts them.
    fn new() -> Self {
        let mut desk = Desk::without_object();
        desk.bench.hand.motor_q_rad = [1.0, 1.0, 1.0, 0.0];
        let (up, over) = (home().map(|q| q + 0.05), home().map(|q| q + 0.2));
        desk.executor.load(&through(1, &[home(), up, over], 0.6)).expect("sound");
        let carry = Carry::new(&desk.bench.readings(0), MASS_KG, Grip::default());
        Self { desk, carry, slip: Slip::default(), slips: 0, end: CarryEnd::NotYet }
    }

    fn tick(&mut self) {
        let stood_rad = self.desk.bench.hand.motor_q_rad;
        let (carry, slip) = (&mut self.carry, &mut self.slip);
        self.end = self.desk.tick(|tools| carry.step(slip, tools));
        let told = |event: &&Event| matches!(event.kind, EventKind::Slip { .. });
        self.slips += self.desk.out.events.iter().filter(told).count();
        // A finger that pushes pushes against something.
        for (f, motor_rad) in self.desk.bench.hand.motor_q_rad.iter_mut().enumerate() {
            if matches!(self.desk.hand[f], HandCommand::Torque(_)) {
                *motor_rad = stood_rad[f];
            }
        }
    }

    fn close_by(&mut self, inner_rad: [f32; FINGERS]) {
        for (f, q_rad) in inner_rad.iter().enumerate() {
            self.desk.bench.hand.motor_q_rad[f] += q_rad;
        }
    }

    fn until(&mut self, done: impl Fn(&Self) -> bool) {
        for _ in 0..TICKS_MAX {
            if done(self) {
                return;
            }
            self.tick();
        }
        panic!("{:?} {:?}", self.carry.step, self.desk.executor.motion());
    }
}

#[test]
fn the_load_is_taken_over_and_given_back_gently() {
    let mut rig = Rig::new();
    let (mut last_kg, mut most_kg) = (0.0_f32, 0.0_f32);
    while matches!(rig.end, CarryEnd::NotYet) {
        rig.tick();
        let now_kg = rig.carry.payload_kg();
        assert!((now_kg - last_kg).abs() < 1.5 * MASS_KG / LOAD_TICKS as f32, "{last_kg} -> {now_kg}");
        (last_kg, most_kg) = (now_kg, most_kg.max(now_kg));
    }
    assert!(matches!(rig.end, CarryEnd::Done));
    assert_eq!((last_kg, most_kg), (0.0, MASS_KG));
}

#[test]
fn the_fingers_open_only_at_the_end_and_only_as_far_as_they_must() {
    let mut rig = Rig::new();
    while !rig.carry.is_releasing() {
        rig.tick();
        assert_eq!(rig.desk.bench.hand.motor_q_rad, [1.0, 1.0, 1.0, 0.0]);
    }
    assert!(rig.desk.executor.at_end());
    rig.until(|rig| matches!(rig.end, CarryEnd::Done));
    for q_rad in rig.desk.bench.hand.motor_q_rad.iter().take(FINGERS) {
        assert!((q_rad - (1.0 - LEFT_RAD)).abs() < 0.02, "{q_rad}");
    }
    let above = home().map(|q| q + 0.05);
    assert!((0..7).all(|j| (rig.desk.bench.q_rad[j] - above[j]).abs() < 1e-3), "the hand has gone back up");
}

#[test]
fn an_object_is_lost_when_nothing_is_left_between_the_two_sides() {
    let gone = LOST_RAD + 0.01;
    let cases = [
        ([0.0, 0.0, gone], true),
        ([gone, gone, 0.0], true),
        ([gone, 0.0, 0.0], false),
        ([0.0, gone, 0.0], false),
        ([LOST_RAD - 0.01; FINGERS], false),
        ([-gone; FINGERS], false),
    ];
    for (closed_by, lost) in cases {
        let mut rig = Rig::new();
        (0..100).for_each(|_| rig.tick());
        rig.close_by(closed_by);
        rig.tick();
        assert_eq!(matches!(rig.end, CarryEnd::Lost), lost, "{closed_by:?}");
        assert_eq!(rig.desk.executor.motion() == Motion::Stopping, lost, "the arm stops if and only if it is lost");
    }
}

#[test]
fn fingers_that_stick_while_opening_do_not_hold_up_the_mission_for_ever() {
    let mut rig = Rig::new();
    rig.until(|rig| matches!(rig.carry.step, Step::Open { .. }));
    for _ in 0..=LEAVING_TICKS_MAX {
        rig.tick();
        rig.desk.bench.hand.motor_q_rad = [1.0, 1.0, 1.0, 0.0];
    }
    assert!(matches!(rig.carry.step, Step::Rise));
}

impl Rig {
    /// A fifth of a second in which the pressure moves across F1's pad.
    fn slide(&mut self) {
        for step in 0..10 {
            self.desk.images = pressed_across(step as f32 / 9.0);
            (0..PAD_PERIOD_TICKS).for_each(|_| self.tick());
            if matches!(self.carry.step, Step::GoBack { .. }) {
                return;
            }
        }
        panic!("a slide of a centimetre is not felt");
    }

    /// The pressure moves a little more than what is slip across F1's pad, and no further.
    fn hint(&mut self) {
        let column_m =
            (Vector3::from(FINGERTIP_TAXELS[14].centre_m) - Vector3::from(FINGERTIP_TAXELS[12].centre_m)).norm();
        for step in 0..9 {
            self.desk.images = pressed_across(if step < 4 { 0.4 } else { 0.4 + 1.4e-3 / column_m });
            (0..PAD_PERIOD_TICKS).for_each(|_| self.tick());
        }
    }

    /// Every finger feels the object and stands.
    fn until_held(&mut self) {
        self.until(|rig| rig.desk.bench.hand.motor_q_rad[2] >= 1.0);
        self.desk.felt.fingers = [true; FINGERS];
        self.until(|rig| matches!(rig.carry.step, Step::Squeeze { .. }));
        self.desk.felt = Felt::default();
    }

    /// The torque that a finger is told, Nm.
    fn told_nm(&self, finger: usize) -> f32 {
        match self.desk.hand[finger] {
            HandCommand::Torque(nm) => nm,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn an_object_that_slips_is_gripped_harder_at_once_brought_back_taken_anew_and_carried() {
    let mut rig = Rig::new();
    let start = rig.desk.bench.q_rad;
    (0..150).for_each(|_| rig.tick());
    rig.slide();
    assert_eq!(rig.slips, 1, "it is told");
    for finger in 0..FINGERS {
        assert_eq!(rig.told_nm(finger), rig.carry.grip().torque_nm(finger));
        assert!(rig.told_nm(finger) > 1.1 * Grip::default().torque_nm(finger), "F{}", finger + 1);
    }
    rig.until(|rig| matches!(rig.carry.step, Step::Open { .. }));
    assert!((0..7).all(|j| (rig.desk.bench.q_rad[j] - start[j]).abs() < 1e-3), "it is back");
    assert!(!rig.carry.is_releasing());
    rig.until(|rig| matches!(rig.carry.step, Step::Close(_)));
    assert_eq!(rig.carry.payload_kg(), 0.0, "and stands");
    rig.until_held();
    let harder_nm = rig.carry.grip().torque_nm(2);
    rig.until(|rig| matches!(rig.carry.step, Step::Move { .. }));
    assert_eq!(rig.told_nm(2), harder_nm);
    rig.until(|rig| matches!(rig.end, CarryEnd::Done));
}

#[test]
fn each_slip_adds_a_step_and_at_the_limit_the_object_is_brought_back_and_not_taken_again() {
    let mut rig = Rig::new();
    let start = rig.desk.bench.q_rad;
    let mut told_nm = Vec::new();
    loop {
        (0..150).for_each(|_| rig.tick());
        rig.slide();
        told_nm.push(rig.carry.grip().torque_nm(2));
        assert!(told_nm.len() < 20, "no limit: {told_nm:?}");
        rig.until(|rig| matches!(rig.carry.step, Step::Close(_)) || matches!(rig.end, CarryEnd::Lost));
        if matches!(rig.end, CarryEnd::Lost) {
            break;
        }
        rig.until_held();
        rig.until(|rig| matches!(rig.carry.step, Step::Move { .. }));
    }
    let (last, steps) = told_nm.split_last().expect("slips");
    assert!(steps.windows(2).all(|pair| pair[1] > pair[0]) && Some(last) == steps.last(), "{told_nm:?}");
    assert!(*last < 1.6, "{last} Nm is more than the fingertip forgives");
    assert!((0..7).all(|j| (rig.desk.bench.q_rad[j] - start[j]).abs() < 1e-3), "it is back");
    assert!(matches!(rig.desk.hand[2], HandCommand::Torque(_)), "and has not been dropped");
}

#[test]
fn a_hint_of_slip_leads_to_a_harder_grip_and_is_let_pass_in_the_hardest() {
    let readings = Rig::new().desk.bench.readings(0);
    let mut hardest = Grip::default();
    while hardest.raise(&readings) {}
    for (grip, heeded) in [(Grip::default(), true), (hardest, false)] {
        let mut rig = Rig::new();
        rig.carry.grip = grip;
        (0..150).for_each(|_| rig.tick());
        rig.hint();
        assert_eq!((rig.slips > 0, matches!(rig.carry.step, Step::GoBack { .. })), (heeded, heeded), "{grip:?}");
    }
}

#[test]
fn an_object_that_is_not_met_again_is_lost() {
    let mut rig = Rig::new();
    (0..150).for_each(|_| rig.tick());
    rig.slide();
    rig.until(|rig| matches!(rig.end, CarryEnd::Lost));
}

#[test]
fn no_step_is_added_beyond_what_the_fingertips_stand() {
    let mut readings = Rig::new().desk.bench.readings(0);
    readings.tip_torque_nm = [0.3, 0.3, 0.95];
    let mut grip = Grip::default();
    assert!(!grip.raise(&readings) && grip == Grip::default());
    readings.tip_torque_nm[2] = 0.7;
    assert!(grip.raise(&readings) && grip != Grip::default());
}

#[test]
fn a_grip_that_was_needed_before_is_taken_before_the_arm_lifts() {
    let mut grip = Grip::default();
    let readings = Rig::new().desk.bench.readings(0);
    assert!(grip.raise(&readings));
    let mut rig = Rig::new();
    rig.carry = Carry::new(&readings, MASS_KG, grip);
    let start = rig.desk.bench.q_rad;
    rig.until(|rig| matches!(rig.carry.step, Step::Close(_)));
    rig.until_held();
    rig.until(|rig| matches!(rig.carry.step, Step::Move { .. }));
    assert_eq!(rig.told_nm(2), grip.torque_nm(2));
    assert!((0..7).all(|j| (rig.desk.bench.q_rad[j] - start[j]).abs() < 1e-3), "it has not moved");
    rig.until(|rig| matches!(rig.end, CarryEnd::Done));
}

#[test]
fn pressure_that_moves_while_the_object_is_set_down_is_no_slip() {
    let mut rig = Rig::new();
    rig.until(|rig| rig.desk.executor.motion() == Motion::Guarded);
    for step in 0..20 {
        rig.desk.images = pressed_across(step as f32 / 19.0);
        (0..PAD_PERIOD_TICKS).for_each(|_| rig.tick());
    }
    assert_eq!(rig.carry.grip(), Grip::default());
    rig.until(|rig| matches!(rig.end, CarryEnd::Done));
}
