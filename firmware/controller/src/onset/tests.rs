//! Promises of contact detection.

use super::*;
use crate::testing::{home, readings};
use proptest::prelude::*;
use tactus_common::limits::{PAD_CELLS, TICK_S};

const NO_IMAGES: [Option<TactileImage>; PADS] = [None; PADS];

/// Ticks until `finger` is felt, with readings as `at` gives them for each tick.
fn felt_after(onset: &mut Onset, finger: usize, ticks: u32, at: impl Fn(u32) -> JointReadings) -> Option<u32> {
    (0..ticks).find(|tick| onset.feel(&at(*tick), &NO_IMAGES).fingers[finger])
}

fn tip(finger: usize, nm: f32) -> JointReadings {
    let mut r = readings(0, home());
    r.tip_torque_nm[finger] = nm;
    r
}

fn bent(finger: usize, rad: f32) -> JointReadings {
    let mut r = readings(0, home());
    r.motor_q_rad[finger] = 0.7;
    r.inner_q_rad = [0.0; FINGERS];
    r.inner_q_rad[finger] = 0.7 - rad;
    r
}

/// An onset that has seen a free hand for a second.
fn settled(at: &JointReadings) -> Onset {
    let mut onset = Onset::default();
    assert_eq!(felt_after(&mut onset, 0, 500, |_| *at), None);
    onset
}

fn image(pad: u8, cell: usize, pressure: f32) -> [Option<TactileImage>; PADS] {
    let mut pressure_n_cm2 = [0.0; PAD_CELLS];
    pressure_n_cm2[cell] = pressure;
    let mut images = NO_IMAGES;
    images[usize::from(pad)] = Some(TactileImage { pad, stamp: 0, pressure_n_cm2 });
    images
}

#[test]
fn a_rise_of_the_tip_torque_is_felt_within_three_ticks_by_its_finger_alone() {
    for finger in 0..FINGERS {
        let mut onset = settled(&tip(finger, -0.4));
        let ticks = felt_after(&mut onset, finger, 3, |_| tip(finger, -0.4 + 1.5 * TIP_RISE_NM));
        assert_eq!(ticks, Some(u32::from(CONFIRM_TICKS) - 1));
        let felt = onset.feel(&tip(finger, -0.4 + 1.5 * TIP_RISE_NM), &NO_IMAGES);
        assert_eq!(felt.fingers.iter().filter(|f| **f).count(), 1);
        assert!(!felt.palm && felt.any());
    }
}

#[test]
fn a_bend_between_motor_and_inner_link_alone_is_felt_within_three_ticks() {
    for finger in 0..FINGERS {
        let mut onset = settled(&bent(finger, 1e-3));
        assert!(felt_after(&mut onset, finger, 3, |_| bent(finger, 1e-3 + 1.5 * BEND_RISE_RAD)).is_some());
    }
}

#[test]
fn one_pressed_cell_alone_is_felt_at_once_and_until_an_image_without_it_comes() {
    let free = readings(0, home());
    for pad in 0..PADS as u8 {
        let mut onset = settled(&free);
        let felt = onset.feel(&free, &image(pad, 23, 1.01 * PRESSURE_N_CM2));
        assert!(if pad == 3 { felt.palm && felt.fingers == [false; FINGERS] } else { felt.fingers[usize::from(pad)] });
        assert!(onset.feel(&free, &NO_IMAGES).any(), "no news: still pressed");
        onset.reset();
        assert!(onset.feel(&free, &NO_IMAGES).any(), "a reset forgets baselines, not what is pressed");
        assert!(!onset.feel(&free, &image(pad, 23, 0.99 * PRESSURE_N_CM2)).any());
    }
}

#[test]
fn a_spike_shorter_than_the_confirmation_is_not_contact_however_high() {
    let mut onset = settled(&tip(0, 0.0));
    let spike = |tick: u32| tip(0, if tick % 10 < u32::from(CONFIRM_TICKS) - 1 { 1.0 } else { 0.0 });
    assert_eq!(felt_after(&mut onset, 0, 1_000, spike), None);
}

#[test]
fn a_slow_drift_is_not_contact_however_far_it_goes() {
    // The baseline lags a steady drift by speed times its time constant.
    let time_constant_s = TICK_S / BASELINE_SHARE;
    let drift = |threshold: f32, tick: u32| 0.8 * threshold / time_constant_s * tick as f32 * TICK_S;
    let mut onset = settled(&tip(1, 0.0));
    assert_eq!(felt_after(&mut onset, 1, 5_000, |t| tip(1, drift(TIP_RISE_NM, t))), None);
    let mut onset = settled(&bent(1, 0.0));
    assert_eq!(felt_after(&mut onset, 1, 5_000, |t| bent(1, drift(BEND_RISE_RAD, t))), None);
}

#[test]
fn a_contact_that_builds_up_in_50_ms_is_felt_and_its_baseline_never_swallows_it() {
    let mut onset = settled(&tip(2, 0.1));
    let contact = |tick: u32| tip(2, 0.1 + 2.0 * TIP_RISE_NM * (tick as f32 / 25.0).min(1.0));
    let first = felt_after(&mut onset, 2, 25, contact).expect("felt while it builds up");
    for tick in first..20_000 {
        assert!(onset.feel(&contact(tick), &NO_IMAGES).fingers[2], "lost after {tick} ticks");
    }
    assert!(!onset.feel(&tip(2, 0.1), &NO_IMAGES).fingers[2], "gone with the contact");
}

#[test]
fn a_reset_takes_what_is_there_as_the_baseline() {
    let mut onset = settled(&tip(0, 0.0));
    onset.reset();
    assert_eq!(felt_after(&mut onset, 0, 500, |_| tip(0, 0.5)), None);
    assert!(felt_after(&mut onset, 0, 3, |_| tip(0, 0.5 + 1.5 * TIP_RISE_NM)).is_some());
}

#[test]
fn pressing_the_other_way_is_not_contact() {
    let mut onset = settled(&tip(0, 0.0));
    assert_eq!(felt_after(&mut onset, 0, 500, |_| tip(0, -1.0)), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn noise_below_half_the_threshold_is_never_contact(noise in prop::collection::vec(-0.25_f32..0.25, 500)) {
        let mut onset = Onset::default();
        for n in noise {
            let mut r = tip(0, n * TIP_RISE_NM);
            r.motor_q_rad[1] = n * BEND_RISE_RAD;
            prop_assert!(!onset.feel(&r, &NO_IMAGES).any());
        }
    }
}
