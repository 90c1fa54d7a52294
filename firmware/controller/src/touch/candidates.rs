//! The touches to choose from, laid out about the object's [`Footprint`].
//!
//! Along its shorter horizontal side a box of 0.1 m leaves open fingers 50-70 mm on either side; along the longer one,
//! at a spread of 90 degrees, 60 mm. A hook reaches over one face from outside with one side of the hand, while the
//! other side stays fully open, 11 mm above the top: for errors that would bring a finger down on the top face.

use super::TouchPlan;
use super::layout::{Footprint, palm_height_m};
use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use tactus_common::limits::FINGERS;
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;

/// Number of candidates.
pub const CANDIDATES: u8 = 16;

/// Inner angle of a finger that will close: 0.5 is too closed, 0 hangs too high (touch study).
pub const PREOPEN_RAD: f32 = 0.25;
/// Half the opening of the tips at [`PREOPEN_RAD`], spread 0.
const HALF_OPENING_M: f32 = 0.135;
/// Gap between a hooking finger and the face that it reaches over.
const HOOK_GAP_M: f32 = 0.06;
/// Shift along the box between touches across it.
const SHIFT_M: f32 = 0.04;
/// Half the length from which on such touches have both F1 and F2 on the face: they close 25 mm beside the middle.
const LONG_M: f32 = SHIFT_M + 0.03;

const ALL: [bool; FINGERS] = [true; FINGERS];
const PAIR: [bool; FINGERS] = [true, true, false];
const THUMB: [bool; FINGERS] = [false, false, true];

/// Candidate `id` (below [`CANDIDATES`]) for an object; `None` beyond.
///
/// 0-5: across the depth, F1 and F2 on the +y side or on the -y side, centred and shifted along x; of a short object centred
/// and turned. 6, 7: F1 and F2 on both end faces, F3 on one side. 8-11: hooks over an end face, with F3 or with F1 and
/// F2. 12-15: the same over a side.
pub fn candidate(id: u8, shape: &ObjectShape) -> Option<TouchPlan> {
    let footprint = Footprint::of(shape);
    let [half_x_m, half_y_m] = footprint.half_m;
    let sign = if id.is_multiple_of(2) { 1.0 } else { -1.0 };
    let across = |x_m: f32, turn_rad: f32| (PlanarPose::new(x_m, 0.0, sign * FRAC_PI_2 + turn_rad), 0.0, ALL);
    let is_long = half_x_m >= LONG_M;
    let (turn_rad, other_turn_rad) = turns_rad(shape);
    // The hand's middle, so that the tips hang the gap outside the face.
    let reach_m = |half_m: f32| half_m + HOOK_GAP_M - HALF_OPENING_M;
    let end_m = sign * reach_m(half_x_m);
    let side_m = sign * reach_m(half_y_m);
    let towards_end = if sign > 0.0 { 0.0 } else { PI };
    let (hand, spread_rad, closes) = match id {
        0 | 1 => across(0.0, 0.0),
        2 | 3 if is_long => across(SHIFT_M, 0.0),
        4 | 5 if is_long => across(-SHIFT_M, 0.0),
        2 | 3 => across(0.0, turn_rad),
        4 | 5 => across(0.0, other_turn_rad),
        6 | 7 => (PlanarPose::new(0.0, 0.0, sign * FRAC_PI_2), FRAC_PI_2, ALL),
        8 | 9 => (PlanarPose::new(end_m, 0.0, PI - towards_end), 0.0, THUMB),
        10 | 11 => (PlanarPose::new(end_m, 0.0, towards_end), 0.0, PAIR),
        12 | 13 => (PlanarPose::new(0.0, side_m, -sign * FRAC_PI_2), 0.0, THUMB),
        14 | 15 => (PlanarPose::new(0.0, side_m, sign * FRAC_PI_2), 0.0, PAIR),
        _ => return None,
    };
    Some(TouchPlan {
        id,
        hand_in_object: footprint.place(hand),
        palm_height_m: palm_height_m(shape),
        spread_rad,
        preopen_rad: closes.map(|c| if c { PREOPEN_RAD } else { 0.0 }),
        closes,
    })
}

/// The turns of touches across a short object: to the next pair of sides like the first, or else to its ends and to its
/// edges.
fn turns_rad(shape: &ObjectShape) -> (f32, f32) {
    let symmetry_rad = shape.yaw_symmetry_rad();
    if symmetry_rad > 0.0 && symmetry_rad < FRAC_PI_2 - 1e-3 {
        (symmetry_rad, -symmetry_rad)
    } else {
        (FRAC_PI_2, FRAC_PI_4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::{FingerPrediction, predict};
    use tactus_common::shape::Hull;

    const SHAPES: [ObjectShape; 8] = [
        ObjectShape::THESIS_BOX,
        ObjectShape::Cuboid { half_extents_m: [0.03, 0.03, 0.15] },
        ObjectShape::Cuboid { half_extents_m: [0.05, 0.1, 0.1] },
        ObjectShape::Cylinder { radius_m: 0.03, half_height_m: 0.075 },
        ObjectShape::Cylinder { radius_m: 0.06, half_height_m: 0.1 },
        ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.02 },
        ObjectShape::Sphere { radius_m: 0.05 },
        ObjectShape::Capsule { radius_m: 0.035, half_length_m: 0.06 },
    ];

    #[test]
    fn aimed_well_every_closing_finger_touches_and_none_lands_whatever_the_shape() {
        let hexagonal_prism = Hull::regular_prism(6, 0.0577, 0.075).unwrap();
        for shape in SHAPES.into_iter().chain([ObjectShape::Convex(hexagonal_prism)]) {
            for at in [PlanarPose::default(), PlanarPose::new(0.2, -0.1, 0.6)] {
                for id in 0..CANDIDATES {
                    let plan = candidate(id, &shape).expect("listed");
                    for (finger, felt) in predict(&plan, &at, &at, &shape).iter().enumerate() {
                        let name = finger + 1;
                        match felt {
                            FingerPrediction::Contact { inner_rad, .. } => {
                                assert!(plan.closes[finger], "{shape:?} {id} F{name}");
                                assert!((0.3..1.9).contains(inner_rad), "{shape:?} {id} F{name}: {inner_rad}");
                            }
                            FingerPrediction::Nothing => assert!(!plan.closes[finger], "{shape:?} {id} F{name} misses"),
                            FingerPrediction::Landed => panic!("{shape:?} {id} F{name} lands"),
                        }
                    }
                }
            }
            assert!(candidate(CANDIDATES, &shape).is_none());
        }
    }
}
