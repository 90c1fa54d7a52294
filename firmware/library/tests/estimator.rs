//! Promise: the estimator of the C interface is the estimator in Rust, and it says what it will not take.

use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use tactus::estimator::*;
use tactus::geometry::{TactusBelief, TactusInterval, TactusMode, TactusPose, TactusShape};
use tactus::result::TactusResult;
use tactus::robot::{TactusHand, TactusReadings, tactus_hand_from_readings};
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::robot::arm;
use tactus_common::robot::hand::HandAngles;
use tactus_common::shape::ObjectShape;
use tactus_controller::belief::{Belief, Prior};
use tactus_controller::evidence::{ContactKind, EvidenceStore, Toucher};
use tactus_controller::predict::{CLOSE_END_RAD, FingerPrediction, predict};
use tactus_controller::touch::{TouchPlan, candidate};
use tactus_controller::update::{Progress, Update, UpdateConfig};
use tactus_controller::work::Work;

const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;
const GUESS: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.0 };
const TRUTH: PlanarPose = PlanarPose { x_m: 0.22, y_m: -0.08, phi_rad: 0.15 };
const INTERVAL: Interval = Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 };

fn prior_c() -> TactusPrior {
    TactusPrior {
        shape: TactusShape { kind: 0, half_extents_m: SHAPE.half_extents_m() },
        guess: GUESS.into(),
        interval: TactusInterval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 },
    }
}

struct FromC {
    _memory: Box<TactusEstimatorMemory>,
    handle: *mut TactusEstimator,
}

impl FromC {
    fn new(prior: &TactusPrior) -> Result<Self, TactusResult> {
        let mut memory = Box::new(TactusEstimatorMemory { words: [0; TACTUS_ESTIMATOR_WORDS] });
        let mut handle = null_mut();
        let place = (&raw mut *memory).cast::<c_void>();
        // SAFETY: the box is as large as the constant says, and lives as long as the handle.
        match unsafe { tactus_estimator_create(place, TACTUS_ESTIMATOR_SIZE, prior, &mut handle) } {
            TactusResult::Ok => Ok(Self { _memory: memory, handle }),
            error => Err(error),
        }
    }

    fn contact(&self, hand: &TactusHand, toucher: u8, kind: u8) -> TactusResult {
        // SAFETY: a live handle and a reference.
        unsafe { tactus_estimator_add_contact(self.handle, hand, toucher, kind) }
    }

    fn slice(&self, work_max: u32) -> (TactusResult, bool) {
        let mut done = false;
        // SAFETY: a live handle and a reference.
        let result = unsafe { tactus_estimator_update(self.handle, work_max, &mut done) };
        (result, done)
    }

    fn belief(&self) -> TactusBelief {
        let mut belief = MaybeUninit::uninit();
        // SAFETY: a live handle; a belief is there from the start.
        unsafe {
            assert_eq!(tactus_estimator_belief(self.handle, belief.as_mut_ptr()), TactusResult::Ok);
            belief.assume_init()
        }
    }
}

fn hand_c(plan: &TouchPlan, inner_rad: [f32; 3]) -> TactusHand {
    let angles = HandAngles::engaged(inner_rad, plan.spread_rad);
    TactusHand {
        world_from_hand: (&plan.world_from_hand(&GUESS, &SHAPE)).into(),
        inner_rad,
        distal_rad: angles.distal_rad,
        spread_rad: angles.spread_rad,
    }
}

/// Feeds a touch to both.
fn touch(c: &FromC, store: &mut EvidenceStore, id: u8) {
    let plan = candidate(id, &SHAPE).expect("listed");
    let hand = plan.world_from_hand(&GUESS, &SHAPE);
    let open = HandAngles::engaged(plan.preopen_rad, plan.spread_rad);
    let open_c = hand_c(&plan, plan.preopen_rad);
    store.begin_touch();
    store.add_free(&hand, &open, [true; 3]).expect("room");
    // SAFETY: a live handle and a reference.
    unsafe {
        assert_eq!(tactus_estimator_begin_touch(c.handle), TactusResult::Ok);
        assert_eq!(tactus_estimator_add_free(c.handle, &open_c, 7), TactusResult::Ok);
    }
    for (finger, felt) in predict(&plan, &GUESS, &TRUTH, &SHAPE).iter().enumerate() {
        if let FingerPrediction::Contact { inner_rad, .. } = felt {
            let mut inner = plan.preopen_rad;
            inner[finger] = *inner_rad;
            let angles = HandAngles::engaged(inner, plan.spread_rad);
            store.add_contact(&hand, &angles, Toucher::Finger(finger), ContactKind::Closing).expect("room");
            assert_eq!(c.contact(&hand_c(&plan, inner), finger as u8, 0), TactusResult::Ok);
        } else if plan.closes[finger] {
            store.add_free_sweep(&hand, &open, finger, CLOSE_END_RAD).expect("room");
            // SAFETY: a live handle and a reference.
            let added = unsafe { tactus_estimator_add_free_sweep(c.handle, &open_c, finger as u8, CLOSE_END_RAD) };
            assert_eq!(added, TactusResult::Ok);
        }
    }
}

#[test]
fn three_touches_fitted_through_the_c_interface_give_what_they_give_in_rust() {
    let prior = Prior { guess: GUESS, interval: INTERVAL, shape: SHAPE };
    let c = FromC::new(&prior_c()).expect("sound");
    let mut store = EvidenceStore::new(SHAPE.top_height_m());
    let mut belief = Belief::from_prior(&prior);
    for id in [0, 6, 3] {
        touch(&c, &mut store, id);
        let mut update = Update::new(&prior, &belief, &UpdateConfig::default());
        while update.step(&mut Work::unlimited(), &store) != Progress::Done {}
        belief = update.belief().clone();
        // Sliced finer than in Rust: that changes nothing.
        while c.slice(3) != (TactusResult::Ok, true) {}
        assert_eq!(c.belief(), TactusBelief::from(&belief), "to the bit");
    }
    let off = c.belief().pose;
    assert!((off.x_m - TRUTH.x_m).abs() < 1e-3 && (off.y_m - TRUTH.y_m).abs() < 1e-3, "{off:?}");
    let mut best = MaybeUninit::<TactusMode>::uninit();
    // SAFETY: a live handle; the mode is read only if it was written.
    unsafe {
        assert_eq!(tactus_estimator_mode(c.handle, 0, best.as_mut_ptr()), TactusResult::Ok);
        assert!(best.assume_init().weight > 0.0);
        assert_eq!(tactus_estimator_mode(c.handle, 12, best.as_mut_ptr()), TactusResult::BadValue);
    }
}

#[test]
fn evidence_is_refused_while_an_update_runs_and_taken_after_it() {
    let c = FromC::new(&prior_c()).expect("sound");
    let mut store = EvidenceStore::new(SHAPE.top_height_m());
    touch(&c, &mut store, 0);
    assert_eq!(c.slice(1), (TactusResult::Ok, false));
    let plan = candidate(0, &SHAPE).expect("listed");
    let hand = hand_c(&plan, [1.0; 3]);
    assert_eq!(c.contact(&hand, 0, 0), TactusResult::Busy);
    while c.slice(50) != (TactusResult::Ok, true) {}
    assert_eq!(c.contact(&hand, 0, 0), TactusResult::Ok);
}

#[test]
fn what_makes_no_sense_never_becomes_evidence() {
    let c = FromC::new(&prior_c()).expect("sound");
    let plan = candidate(0, &SHAPE).expect("listed");
    let good = hand_c(&plan, [1.0; 3]);
    let mut crooked = good;
    crooked.world_from_hand.rotation_ijkw = [0.0; 4];
    let mut nowhere = good;
    nowhere.world_from_hand.position_m[0] = f32::NAN;
    let mut bent = good;
    bent.distal_rad[1] = f32::INFINITY;
    for bad in [&crooked, &nowhere, &bent] {
        assert_eq!(c.contact(bad, 0, 0), TactusResult::BadValue);
    }
    assert_eq!(c.contact(&good, 4, 0), TactusResult::BadValue, "no such finger");
    assert_eq!(c.contact(&good, 0, 3), TactusResult::BadValue, "no such kind");
    // SAFETY: a live handle and references.
    unsafe {
        assert_eq!(tactus_estimator_add_free(c.handle, &good, 8), TactusResult::BadValue);
        assert_eq!(tactus_estimator_add_free_sweep(c.handle, &good, 3, 2.0), TactusResult::BadValue);
        assert_eq!(tactus_estimator_add_contact(c.handle, null(), 0, 0), TactusResult::NullPointer);
    }
    assert_eq!(c.slice(0).0, TactusResult::BadValue);
    while c.slice(50) != (TactusResult::Ok, true) {}
    assert_eq!(c.belief().contacts, 0);
    let bad = TactusPrior { guess: TactusPose { x_m: 11.0, ..prior_c().guess }, ..prior_c() };
    assert_eq!(FromC::new(&bad).err(), Some(TactusResult::BadValue));
}

#[test]
fn a_full_estimator_says_so_and_takes_more_once_it_is_cleared() {
    let c = FromC::new(&prior_c()).expect("sound");
    let plan = candidate(0, &SHAPE).expect("listed");
    let hand = hand_c(&plan, [1.0; 3]);
    let mut taken = 0;
    while c.contact(&hand, 0, 0) == TactusResult::Ok {
        taken += 1;
        assert!(taken < 1_000);
    }
    assert_eq!(c.contact(&hand, 0, 0), TactusResult::Full);
    // SAFETY: a live handle.
    assert_eq!(unsafe { tactus_estimator_clear(c.handle) }, TactusResult::Ok);
    assert_eq!(c.contact(&hand, 0, 0), TactusResult::Ok);
}

#[test]
fn the_hand_is_where_the_readings_say() {
    let mut readings = TactusReadings {
        arm_q_rad: [0.1, 0.2, 0.3, 1.4, 0.5, 0.6, 0.7],
        motor_q_rad: [0.3, 0.6, 0.9, 1.2],
        inner_q_rad: [0.3, 0.6, 0.9],
        effort_nm: [0.0; 4],
        tip_torque_nm: [0.0; 3],
        valid: tactus::robot::TACTUS_VALID_ALL,
    };
    let mut hand = MaybeUninit::uninit();
    // SAFETY: references; the hand is read only if it was written.
    let found: TactusHand = unsafe {
        assert_eq!(tactus_hand_from_readings(&readings, hand.as_mut_ptr()), TactusResult::Ok);
        hand.assume_init()
    };
    assert_eq!(found.world_from_hand, (&arm::hand_pose(&readings.arm_q_rad)).into());
    assert!((found.distal_rad[2] - 0.3).abs() < 1e-6, "engaged: a third of the inner angle");
    readings.valid &= !1;
    // SAFETY: as above.
    assert_eq!(unsafe { tactus_hand_from_readings(&readings, hand.as_mut_ptr()) }, TactusResult::BadValue);
}
