//! Promises of the executor.

use super::*;
use crate::testing::{Joints, home, rest, through, travel_s};
use proptest::prelude::*;
use tactus_common::limits::ARM_ACCELERATION_MAX_RAD_S2;
use tactus_common::trajectory::Knot;

const TICKS_MAX: usize = 20_000;

/// A sound trajectory: out over two postures, the second leg guarded.
fn out_and_down() -> Trajectory {
    let start = home();
    through(7, &[start, start.map(|q| q + 0.2), start.map(|q| q + 0.25)], 0.5)
}

fn loaded(trajectory: &Trajectory) -> Executor {
    let mut executor = Executor::holding(trajectory.knots[0].q_rad);
    executor.load(trajectory).expect("sound");
    executor
}

/// Ticks until `motion` is reached; every reference on the way.
fn until(executor: &mut Executor, motion: Motion, mut see: impl FnMut(&Sample)) -> usize {
    for tick in 0..TICKS_MAX {
        if executor.motion() == motion {
            return tick;
        }
        see(&executor.tick());
    }
    panic!("{motion:?} not reached from {:?}", executor.motion());
}

/// Largest steps of a reference in one tick, against what the limits of its derivatives allow.
struct Watch {
    last: Sample,
    rate: f32,
    acceleration_step: f32,
}

impl Watch {
    fn new(executor: &Executor) -> Self {
        Self { last: *executor.reference(), rate: 1.0, acceleration_step: 0.0 }
    }

    /// Position may move by speed times tick, velocity by acceleration times tick (both with a little for rounding).
    fn see(&mut self, now: &Sample) {
        for j in 0..ARM_JOINTS {
            let speed = ARM_LIMITS[j].velocity_rad_s * self.rate;
            let step = (now.q_rad[j] - self.last.q_rad[j]).abs();
            assert!(step <= 1.02 * speed * TICK_S + 1e-5, "J{}: position jumps by {step}", j + 1);
            let slope = RATE_SLOPE * ARM_LIMITS[j].velocity_rad_s;
            let allowed = ARM_ACCELERATION_MAX_RAD_S2[j] * self.rate * self.rate + slope;
            let step = (now.qd_rad_s[j] - self.last.qd_rad_s[j]).abs();
            assert!(step <= 1.02 * allowed * TICK_S + 2e-3, "J{}: velocity jumps by {step}", j + 1);
            let mean = 0.5 * (now.qd_rad_s[j] + self.last.qd_rad_s[j]);
            let moved = (now.q_rad[j] - self.last.q_rad[j]) / TICK_S;
            assert!((moved - mean).abs() <= allowed * TICK_S + 3e-3, "J{}: {moved} is not the velocity {mean}", j + 1);
            self.acceleration_step = self.acceleration_step.max((now.qdd_rad_s2[j] - self.last.qdd_rad_s2[j]).abs());
        }
        self.last = *now;
    }
}

/// Any checked trajectory: rest, a posture passed in motion, rest (the guarded part begins), rest.
fn any_trajectory() -> impl Strategy<Value = Trajectory> {
    let offsets = || prop::array::uniform7(-0.3_f32..0.3);
    (offsets(), offsets(), offsets(), prop::array::uniform7(-0.2_f32..0.2)).prop_map(|(a, b, c, qd_rad_s)| {
        let moved = |d: &Joints| core::array::from_fn(|j| home()[j] + d[j]);
        let (pass, guard, end): (Joints, Joints, Joints) = (moved(&a), moved(&b), moved(&c));
        let mut stretch = 1.0;
        loop {
            let mut t = through(1, &[home(), pass, guard, end], 0.8);
            for knot in &mut t.knots {
                knot.t_s *= stretch;
            }
            t.knots[1] = Knot { qd_rad_s: qd_rad_s.map(|v| v / stretch), ..t.knots[1] };
            if t.check(&ARM_LIMITS).is_ok() {
                return t;
            }
            stretch *= 1.3;
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn unstopped_the_reference_is_continuous_in_position_velocity_and_acceleration(t in any_trajectory()) {
        let mut executor = loaded(&t);
        let mut watch = Watch::new(&executor);
        until(&mut executor, Motion::AtGuard, |s| watch.see(s));
        executor.enter_guarded();
        until(&mut executor, Motion::Holding, |s| watch.see(s));
        prop_assert!(executor.at_end());
        prop_assert_eq!(executor.reference().q_rad, t.knots.last().unwrap().q_rad);
        // A quintic over 0.8 s or more within these accelerations: its jerk is below 60 a / T.
        prop_assert!(watch.acceleration_step < 60.0 * 12.0 / 0.8 * TICK_S, "{}", watch.acceleration_step);
    }

    #[test]
    fn stopped_anywhere_it_stands_within_25_ms_on_the_path_and_goes_back_without_a_jump(
        t in any_trajectory(), share in 0.0_f32..1.0, rate in 0.3_f32..3.0, again in prop::option::of(1_usize..200),
    ) {
        let mut executor = loaded(&t);
        let mut watch = Watch::new(&executor);
        let guard_s = t.guarded_from_s().unwrap();
        let stop_s = share * t.duration();
        for _ in 0..(stop_s / TICK_S) as usize {
            executor.enter_guarded();
            watch.see(&executor.tick());
        }
        executor.enter_guarded();
        executor.stop();
        prop_assert!(until(&mut executor, Motion::Holding, |s| watch.see(s)) <= 13, "25 ms are 12.5 ticks");
        watch.see(&executor.tick());
        prop_assert_eq!(executor.reference().qd_rad_s, [0.0; ARM_JOINTS]);
        let q_rad = executor.reference().q_rad;
        let near = (0..30).filter_map(|k| t.sample(stop_s + k as f32 * 0.5 * TICK_S - 5.0 * TICK_S)).any(|on_path| {
            (0..ARM_JOINTS).all(|j| (on_path.q_rad[j] - q_rad[j]).abs() < 1e-3)
        });
        prop_assert!(near, "left the path");
        // Back, perhaps stopped once more on the way.
        watch.rate = rate;
        executor.go_back(rate);
        if let Some(ticks) = again {
            for _ in 0..ticks {
                watch.see(&executor.tick());
            }
            executor.stop();
            until(&mut executor, Motion::Holding, |s| watch.see(s));
            executor.go_back(rate);
        }
        until(&mut executor, Motion::Holding, |s| watch.see(s));
        watch.see(&executor.tick());
        if again.is_none() {
            // It ran on for 9 ms of the path; a little before or after the guard it may be either.
            let past_s = stop_s + 0.009 - guard_s;
            let is_at = |t_s: f32| {
                let wanted = t.sample(t_s).unwrap().q_rad;
                (0..ARM_JOINTS).all(|j| (wanted[j] - executor.reference().q_rad[j]).abs() < 1e-4)
            };
            prop_assert!(past_s < 2.0 * TICK_S && is_at(0.0) || past_s > -2.0 * TICK_S && is_at(guard_s), "{past_s}");
        }
    }
}

#[test]
fn a_moving_arm_takes_no_other_trajectory() {
    let t = out_and_down();
    let mut executor = loaded(&t);
    executor.tick();
    assert_eq!(executor.load(&t), Err(LoadError::Busy));
    until(&mut executor, Motion::AtGuard, |_| ());
    assert_eq!(executor.load(&t), Err(LoadError::Busy), "nor does one that waits at the guard");
}

#[test]
fn a_trajectory_that_starts_elsewhere_is_refused_by_its_first_joint_and_changes_nothing() {
    let t = out_and_down();
    let mut away = home();
    away[3] += 1.01 * START_TOLERANCE_RAD;
    away[5] -= 1.0;
    let mut executor = Executor::holding(away);
    assert_eq!(executor.load(&t), Err(LoadError::StartMismatch { joint: 3 }));
    assert_eq!(executor.tick(), still(away));
    assert_eq!(executor.motion(), Motion::Holding);
}

#[test]
fn a_trajectory_that_breaks_a_limit_or_holds_nothing_is_refused_with_the_reason() {
    let mut executor = Executor::holding(home());
    assert_eq!(executor.load(&Trajectory::default()), Err(LoadError::Unsound(TrajectoryError::Empty)));
    let mut fast = out_and_down();
    fast.knots[1].t_s *= 0.3;
    assert!(matches!(executor.load(&fast), Err(LoadError::Unsound(_))));
}

#[test]
fn a_trajectory_that_moves_at_its_start_or_where_the_guarded_part_begins_is_refused() {
    let mut executor = Executor::holding(home());
    for knot in [0, 1] {
        let mut t = out_and_down();
        t.knots[knot].qd_rad_s[2] = 0.01;
        assert_eq!(executor.load(&t), Err(LoadError::NoRest { knot: knot as u8 }));
        let mut t = out_and_down();
        t.knots[knot].qdd_rad_s2[2] = 0.01;
        assert_eq!(executor.load(&t), Err(LoadError::NoRest { knot: knot as u8 }));
    }
    assert_eq!(executor.load(&out_and_down()), Ok(()));
}

#[test]
fn it_waits_at_the_guard_until_it_is_entered() {
    let t = out_and_down();
    let mut executor = loaded(&t);
    let ticks = until(&mut executor, Motion::AtGuard, |_| ());
    assert_eq!(ticks, libm::ceilf(t.knots[1].t_s / TICK_S) as usize);
    for _ in 0..500 {
        assert_eq!(executor.tick(), still(t.knots[1].q_rad));
    }
    assert!(!executor.at_end());
    executor.enter_guarded();
    until(&mut executor, Motion::Holding, |_| ());
    assert!(executor.at_end());
}

#[test]
fn a_trajectory_guarded_from_its_start_waits_there() {
    let mut t = out_and_down();
    t.guarded_from = 0;
    let mut executor = loaded(&t);
    executor.tick();
    assert_eq!((executor.motion(), executor.reference().q_rad), (Motion::AtGuard, home()));
    executor.enter_guarded();
    until(&mut executor, Motion::Holding, |_| ());
    assert!(executor.at_end());
}

#[test]
fn without_a_guarded_part_it_runs_through_and_goes_back_to_the_start() {
    let mut t = out_and_down();
    t.guarded_from = 255;
    let mut executor = loaded(&t);
    until(&mut executor, Motion::Holding, |_| ());
    assert!(executor.at_end());
    executor.go_back(1.0);
    until(&mut executor, Motion::Holding, |_| ());
    assert_eq!(executor.reference().q_rad, home());
}

#[test]
fn a_way_back_asked_for_in_the_very_tick_of_arrival_does_not_run_on_first() {
    let mut executor = loaded(&out_and_down());
    until(&mut executor, Motion::AtGuard, |_| ());
    executor.enter_guarded();
    let ticks = until(&mut executor, Motion::Holding, |_| ());
    executor.go_back(1.0);
    // The rate falls from 0 to -1 in 200 ms, so the way back takes 100 ms more than the way there.
    let back = until(&mut executor, Motion::Holding, |_| ());
    assert!(back <= ticks + 52, "{back} ticks back, {ticks} there");
}

#[test]
fn the_way_back_is_as_much_faster_as_asked() {
    let slow = through(1, &[home(), home().map(|q| q + 0.05)], 4.0);
    let ticks = |rate: f32| {
        let mut executor = loaded(&slow);
        executor.tick();
        executor.enter_guarded();
        until(&mut executor, Motion::Holding, |_| ());
        executor.go_back(rate);
        until(&mut executor, Motion::Holding, |_| ()) as f32
    };
    let travel = travel_s(&home(), &home().map(|q| q + 0.05), 4.0) / TICK_S;
    assert!((ticks(1.0) - travel - 50.0).abs() < 3.0);
    assert!((ticks(2.0) - travel / 2.0 - 100.0).abs() < 3.0);
}

#[test]
fn what_is_held_by_order_has_no_way_back_to_a_forgotten_trajectory() {
    let mut executor = loaded(&out_and_down());
    until(&mut executor, Motion::AtGuard, |_| ());
    let here = home().map(|q| q - 0.5);
    executor.hold(here);
    executor.go_back(1.0);
    for _ in 0..100 {
        assert_eq!(executor.tick(), still(here));
    }
}

#[test]
fn stop_and_enter_mean_nothing_to_an_arm_that_stands() {
    let mut executor = Executor::holding(home());
    executor.stop();
    executor.enter_guarded();
    assert_eq!(executor.tick(), still(home()));
    assert_eq!(executor.motion(), Motion::Holding);
    let mut t = out_and_down();
    t.knots[0] = rest(0.0, home());
    assert_eq!(executor.load(&t), Ok(()), "and it takes the next trajectory");
}
