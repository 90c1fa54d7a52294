//! The touches to choose from, laid out about the object's bounding box.
//!
//! Along its shorter horizontal side a box of 0.1 m leaves open fingers 50-70 mm on either side; along the longer one,
//! at a spread of 90 degrees, 60 mm. A hook reaches over one face from outside with one side of the hand, while the
//! other side stays fully open, 11 mm above the top: for errors that would bring a finger down on the top face.

use super::TouchPlan;
use core::f32::consts::{FRAC_PI_2, PI};
use tactus_common::limits::FINGERS;
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;

/// Number of candidates.
pub const CANDIDATES: u8 = 16;

/// Palm above the object's top face: the inner links, closed across 0.1 m, need 30 mm (facts 2.6), and fully open
/// fingers hang 35 mm below the palm.
pub const PALM_HEIGHT_M: f32 = 0.046;
/// Inner angle of a finger that will close: 0.5 is too closed, 0 hangs too high (touch study).
pub const PREOPEN_RAD: f32 = 0.25;
/// Half the opening of the tips at [`PREOPEN_RAD`], spread 0.
const HALF_OPENING_M: f32 = 0.135;
/// Gap between a hooking finger and the face that it reaches over.
const HOOK_GAP_M: f32 = 0.06;
/// Shift along the box between touches across it.
const SHIFT_M: f32 = 0.04;

const ALL: [bool; FINGERS] = [true; FINGERS];
const PAIR: [bool; FINGERS] = [true, true, false];
const THUMB: [bool; FINGERS] = [false, false, true];

/// Candidate `id` (below [`CANDIDATES`]) for an object; `None` beyond.
///
/// 0-5: across the depth, F1 and F2 on the +y side or on the -y side, centred and shifted along x. 6, 7: F1 and F2 on
/// both end faces, F3 on one side. 8-11: hooks over an end face, with F3 or with F1 and F2. 12-15: the same over a side.
pub fn candidate(id: u8, shape: &ObjectShape) -> Option<TouchPlan> {
    let [half_x_m, half_y_m, _] = shape.half_extents_m();
    let sign = if id.is_multiple_of(2) { 1.0 } else { -1.0 };
    let across = |x_m: f32| plan(id, PlanarPose::new(x_m, 0.0, sign * FRAC_PI_2), 0.0, ALL);
    // The hand's middle, so that the tips hang the gap outside the face.
    let reach_m = |half_m: f32| half_m + HOOK_GAP_M - HALF_OPENING_M;
    let end_m = sign * reach_m(half_x_m);
    let side_m = sign * reach_m(half_y_m);
    let towards_end = if sign > 0.0 { 0.0 } else { PI };
    Some(match id {
        0 | 1 => across(0.0),
        2 | 3 => across(SHIFT_M),
        4 | 5 => across(-SHIFT_M),
        6 | 7 => plan(id, PlanarPose::new(0.0, 0.0, sign * FRAC_PI_2), FRAC_PI_2, ALL),
        8 | 9 => plan(id, PlanarPose::new(end_m, 0.0, PI - towards_end), 0.0, THUMB),
        10 | 11 => plan(id, PlanarPose::new(end_m, 0.0, towards_end), 0.0, PAIR),
        12 | 13 => plan(id, PlanarPose::new(0.0, side_m, -sign * FRAC_PI_2), 0.0, THUMB),
        14 | 15 => plan(id, PlanarPose::new(0.0, side_m, sign * FRAC_PI_2), 0.0, PAIR),
        _ => return None,
    })
}

fn plan(id: u8, hand_in_object: PlanarPose, spread_rad: f32, closes: [bool; FINGERS]) -> TouchPlan {
    TouchPlan {
        id,
        hand_in_object,
        palm_height_m: PALM_HEIGHT_M,
        spread_rad,
        preopen_rad: closes.map(|c| if c { PREOPEN_RAD } else { 0.0 }),
        closes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::{FingerPrediction, predict};

    #[test]
    fn aimed_well_every_closing_finger_touches_and_none_lands() {
        let shape = ObjectShape::THESIS_BOX;
        for at in [PlanarPose::default(), PlanarPose::new(0.2, -0.1, 0.6)] {
            for id in 0..CANDIDATES {
                let plan = candidate(id, &shape).expect("listed");
                for (finger, felt) in predict(&plan, &at, &at, &shape).iter().enumerate() {
                    match felt {
                        FingerPrediction::Contact { inner_rad, .. } => {
                            assert!(plan.closes[finger], "{id} F{}", finger + 1);
                            assert!((0.3..1.9).contains(inner_rad), "{id} F{}: {inner_rad}", finger + 1);
                        }
                        FingerPrediction::Nothing => assert!(!plan.closes[finger], "{id} F{} misses", finger + 1),
                        FingerPrediction::Landed => panic!("{id} F{} lands", finger + 1),
                    }
                }
            }
        }
        assert!(candidate(CANDIDATES, &shape).is_none());
    }
}
