//! Promises of felt touches.

extern crate std;

use super::*;
use crate::predict::predict;
use crate::touch::{candidate, rehearse::rehearse_felt};
use tactus_common::shape::ObjectShape;

const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;
const AIM: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.1 };
const TRUTH: PlanarPose = PlanarPose { x_m: 0.21, y_m: -0.09, phi_rad: 0.2 };

fn touch(id: u8) -> FeltTouch {
    rehearse_felt(&candidate(id, &SHAPE).expect("listed"), &AIM, &TRUTH, &SHAPE)
}

#[test]
fn a_recorded_closing_is_what_the_predictor_foretells() {
    for id in [0, 3, 7, 8, 14] {
        let expected = touch(id);
        let prediction = predict(&expected.plan, &AIM, &TRUTH, &SHAPE);
        let mut store = FeltTouches::default();
        store.begin(&expected.plan, &expected.world_from_hand, expected.arm_q_rad);
        // The fingers close at their speed; each stands where it touches.
        let mut inner_rad = expected.plan.preopen_rad;
        loop {
            let (mut links, mut all_stand) = (0, true);
            for (finger, felt) in prediction.iter().enumerate() {
                let (end_rad, bit) = match felt {
                    FingerPrediction::Contact { inner_rad, link, .. } => (*inner_rad, 1_u16 << link.index()),
                    _ if expected.plan.closes[finger] => (CLOSED_RAD, 0),
                    _ => (expected.plan.preopen_rad[finger], 0),
                };
                inner_rad[finger] = (inner_rad[finger] + CLOSING_RAD_S * TICK_S).min(end_rad);
                let stands = inner_rad[finger] >= end_rad;
                links |= if stands { bit } else { 0 };
                all_stand &= stands;
            }
            store.feel(Some(links));
            if all_stand {
                break;
            }
        }
        store.end(inner_rad);
        let [recorded] = store.touches() else { panic!("one touch") };
        // A finger that touches within a tick of a row's instant may come a row earlier or later.
        let rows = recorded.felt.contacts.rows().iter().zip(expected.felt.contacts.rows());
        let differences: u32 = rows.map(|(a, b)| (a ^ b).count_ones()).sum();
        assert!(differences <= 1, "{id}: {recorded:?} {expected:?}");
        assert_eq!(recorded.felt.contacts.rows().len(), ROLLOUT_INSTANTS);
        for (a, b) in recorded.felt.inner_rad.iter().zip(expected.felt.inner_rad) {
            assert!((a - b).abs() < 2e-3, "{id}: {a} {b}");
        }
    }
}

#[test]
fn a_rollout_with_the_same_onsets_is_the_same_closing_whatever_its_pace() {
    for id in [0, 6, 9] {
        let felt = touch(id);
        let prediction = predict(&felt.plan, &AIM, &TRUTH, &SHAPE);
        let mut result =
            RolloutResult { effective: 0, request: 0, onset_inner_rad: [None; 3], contacts: [0; ROLLOUT_INSTANTS] };
        for (finger, foretold) in prediction.iter().enumerate() {
            if let FingerPrediction::Contact { inner_rad, link, .. } = foretold {
                result.onset_inner_rad[finger] = Some(*inner_rad);
                for row in &mut result.contacts[9..] {
                    *row |= 1 << link.index();
                }
            }
        }
        assert_eq!(felt.rolled_out(&result), felt.felt);
    }
}

#[test]
fn a_rollout_sweeps_the_whole_closing_of_the_fingers_that_close() {
    let question = touch(8).question(&TRUTH);
    assert_eq!(question.closing_rad_s.map(|v| v > 0.0), [false, false, true]);
    let swept_rad = question.closing_rad_s[2] * f32::from(question.ticks) * TICK_S;
    assert!(swept_rad > CLOSED_RAD - question.preshape.inner_rad[2], "{swept_rad}");
    let landed = FeltTouch { landed: true, ..touch(8) };
    assert_eq!(landed.question(&TRUTH).closing_rad_s, [0.0; 3]);
}

#[test]
fn nothing_is_kept_of_a_hand_whose_links_tell_nothing() {
    let (mut store, felt) = (FeltTouches::default(), touch(0));
    store.begin(&felt.plan, &felt.world_from_hand, felt.arm_q_rad);
    store.feel(None);
    store.end([1.0; 3]);
    store.landed(&felt.plan, &felt.world_from_hand, felt.arm_q_rad, [0.25; 3], None);
    assert_eq!(store.touches(), []);
}

#[test]
fn a_landing_is_the_same_at_every_instant_and_the_oldest_touch_is_forgotten() {
    let (mut store, felt) = (FeltTouches::default(), touch(0));
    for bit in 0..=TOUCHES_MAX {
        store.landed(&felt.plan, &felt.world_from_hand, felt.arm_q_rad, [0.25; 3], Some(1 << bit));
    }
    assert_eq!(store.touches().len(), TOUCHES_MAX);
    for (touch, bit) in store.touches().iter().zip(1..) {
        assert!(touch.landed);
        assert_eq!(touch.felt.contacts.rows(), [1 << bit; ROLLOUT_INSTANTS]);
    }
}
