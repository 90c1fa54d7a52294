//! Promises of the carrying.

use super::*;
use crate::testing::{Desk, home, through};

const MASS_KG: f32 = 0.6;
const TICKS_MAX: u32 = 20_000;

struct Rig {
    desk: Desk,
    carry: Carry,
    end: CarryEnd,
}

impl Rig {
    /// Fingers at one radian around nothing that the bench knows of: they stand where the test puts them.
    fn new() -> Self {
        let mut desk = Desk::without_object();
        desk.bench.hand.motor_q_rad = [1.0, 1.0, 1.0, 0.0];
        let (up, over) = (home().map(|q| q + 0.05), home().map(|q| q + 0.2));
        desk.executor.load(&through(1, &[home(), up, over], 0.6)).expect("sound");
        let carry = Carry::new(&desk.bench.readings(0), MASS_KG);
        Self { desk, carry, end: CarryEnd::NotYet }
    }

    fn tick(&mut self) {
        let carry = &mut self.carry;
        self.end = self.desk.tick(|tools| carry.step(tools));
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
