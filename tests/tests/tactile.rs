//! Promise: the cells that report pressure are those that touch. For every image in which a fingertip feels the box, the
//! pressed cells are looked up in the controller's tables, placed by its kinematics from what the joints read, and
//! compared with where the box truly stands: contact forces, cell order, wire and tables must agree.

use std::collections::BTreeMap;
use tactus_common::limits::FINGERS;
use tactus_common::message::Phase;
use tactus_common::robot::hand::{self, HandAngles, HandLink};
use tactus_common::robot::{FINGERTIP_TAXELS, arm};
use tactus_tests::recording::Recording;

/// Pressure of all cells together from which an image counts, N/cm^2.
const PRESSED_N_CM2: f32 = 1.0;
/// Half extents of the box and where it stands, metres.
const HALF_M: [f32; 3] = [0.1, 0.05, 0.1];
/// Most that the middle of the pressed cells may be off, millimetres: half a cell.
const OFF_MM: f32 = 2.0;
/// A cell that much further from the box than the nearest one is hardly pressed, metres.
const FALL_OFF_M: f32 = 0.0002;

/// A pad this much nearer to the box on one side than on the other is pressed on that side, metres.
const DECISIVE_TILT_M: f32 = 0.0004;
/// Rows and columns of a fingertip pad.
const ROWS: f32 = 8.0;
const COLUMNS: usize = 3;

/// Median of lengths in metres, millimetres. There must be some.
fn median_mm(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.collect();
    assert!(!values.is_empty(), "nothing to compare");
    values.sort_by(f32::total_cmp);
    values[values.len() / 2] * 1e3
}

/// Middle of the cells with these weights, in the tip's frame, metres.
fn middle(weights: &[f32]) -> [f32; 3] {
    let sum: f32 = weights.iter().sum();
    let part =
        |axis: usize| weights.iter().zip(&FINGERTIP_TAXELS).map(|(w, t)| w * t.centre_m[axis]).sum::<f32>() / sum;
    [part(0), part(1), part(2)]
}

/// Distance of a point in the box's frame from its surface, negative inside, metres.
fn distance_m(point: [f32; 3]) -> f32 {
    let q: Vec<f32> = point.iter().zip(HALF_M).map(|(p, half)| p.abs() - half).collect();
    let outside: f32 = q.iter().map(|v| v.max(0.0).powi(2)).sum();
    libm::sqrtf(outside) + q.iter().copied().fold(f32::MIN, f32::max).min(0.0)
}

#[test]
fn pressed_cells_are_those_at_the_surface_of_the_box() {
    let recording = Recording::shared();
    let truth = recording.options.truth;
    let object_from_world = truth.isometry(HALF_M[2]).inverse();
    // By finger: felt minus expected middle along the finger and across it, and distance of the felt middle, metres.
    let mut found: BTreeMap<usize, Vec<(f32, Option<f32>, f32)>> = BTreeMap::new();
    let mut told = recording.told.iter();
    recording.play(|rig, _| {
        let image = told.next().and_then(|t| t.image).and_then(|slice| slice.unpack());
        // In trials the box stands where it stood, within a millimetre.
        let Some(image) = image.filter(|i| usize::from(i.pad) < FINGERS && rig.phase() == Phase::Trial) else {
            return true;
        };
        if image.pressure_n_cm2.iter().sum::<f32>() < PRESSED_N_CM2 {
            return true;
        }
        let readings = rig.readings();
        let angles = HandAngles::from_readings(&readings.motor_q_rad, &readings.inner_q_rad);
        let finger = usize::from(image.pad);
        let tip = HandLink::TIPS[finger];
        let object_from_tip =
            object_from_world * hand::link_poses(&arm::hand_pose(&readings.arm_q_rad), &angles)[tip.index()];
        let distances: Vec<f32> = FINGERTIP_TAXELS
            .iter()
            .map(|t| {
                let [x, y, z] = t.centre_m;
                let p = object_from_tip.rotation * nalgebra::Vector3::new(x, y, z) + object_from_tip.translation.vector;
                distance_m([p.x, p.y, p.z])
            })
            .collect();
        let nearest = distances.iter().copied().fold(f32::MAX, f32::min);
        let expected: Vec<f32> = distances.iter().map(|d| (-((d - nearest) / FALL_OFF_M)).exp2()).collect();
        let (felt, expected) = (middle(&image.pressure_n_cm2), middle(&expected));
        let distance: f32 = image.pressure_n_cm2.iter().zip(&distances).map(|(p, d)| p * d).sum::<f32>()
            / image.pressure_n_cm2.iter().sum::<f32>();
        // The outer columns' distances: where they hardly differ, pad and face are parallel, and which edge of the pad
        // carries a gentle touch is decided by less than is known here.
        let column_m = |c: usize| distances.iter().skip(c).step_by(COLUMNS).sum::<f32>() / ROWS;
        let tilt_m = (column_m(0) - column_m(COLUMNS - 1)).abs();
        let across = (tilt_m > DECISIVE_TILT_M).then_some(felt[2] - expected[2]);
        found.entry(finger).or_default().push((felt[0] - expected[0], across, distance));
        true
    });
    assert_eq!(found.len(), FINGERS, "every finger has felt something");
    println!(
        "Medians, mm: felt minus expected middle along and across the finger, distance of the pressed cells from the box"
    );
    for (finger, off) in &found {
        let along = median_mm(off.iter().map(|o| o.0));
        let across = median_mm(off.iter().filter_map(|o| o.1));
        let distance = median_mm(off.iter().map(|o| o.2));
        println!("  F{}: {along:+.2} {across:+.2} {distance:+.2} in {} images", finger + 1, off.len());
        assert!(along.abs() < OFF_MM && across.abs() < OFF_MM, "F{}: not the cells that touch", finger + 1);
        assert!(distance.abs() < OFF_MM, "F{}: {distance} mm from the box", finger + 1);
    }
}
