//! Kinematic predictor: what the hand would feel if the object stood at a hypothesised pose.
//!
//! Closes the modelled fingers on the shape, TorqueSwitch engaged, until a link touches: conservative advancement
//! (a step never longer than the separation over the fastest point's speed), so nothing is jumped over.

use crate::touch::TouchPlan;
use tactus_common::limits::FINGERS;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::{self, HandAngles};
use tactus_common::robot::{HandLink, hand_prism};
use tactus_common::shape::{ObjectShape, Separation};

use nalgebra::Isometry3;

/// Inner angle to which a finger closes if it meets nothing, radians: past this it folds over the palm.
pub const CLOSE_END_RAD: f32 = 2.0;
/// Speed of the fastest point of a finger per inner-link speed, metres per radian: inner link 0.07 m plus 4/3 of the
/// tip's 0.06 m.
const REACH_M: f32 = 0.15;
/// A link this near touches, metres.
const TOUCH_M: f32 = 1e-4;
/// Penetration in the opened configuration from which a finger counts as landed on the object, metres.
const LANDED_M: f32 = 5e-4;
/// Shortest step, radians: 1.5 mm at the tip, then interpolated.
const STEP_MIN_RAD: f32 = 0.01;
/// Most steps of one finger's closing.
const STEPS_MAX: usize = 48;

/// What one finger would feel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FingerPrediction {
    /// Closes without touching anything, or does not close.
    #[default]
    Nothing,
    /// Comes down on the object before it can close.
    Landed,
    /// Touches while closing.
    Contact {
        /// Inner-link angle at the onset, radians.
        inner_rad: f32,
        /// The link that touches.
        link: HandLink,
        /// Change of that link's separation with the object's pose, per metre in x and y and per radian, world axes.
        gradient: [f32; 3],
    },
}

/// What the hand would feel.
pub type Prediction = [FingerPrediction; FINGERS];

/// What the touch `plan`, aimed at an object believed at `believed`, would feel if it stood at `hypothesis`.
///
/// At most `3 * 48` closing steps, in practice about 30.
pub fn predict(plan: &TouchPlan, believed: &PlanarPose, hypothesis: &PlanarPose, shape: &ObjectShape) -> Prediction {
    let world_from_hand = plan.world_from_hand(believed, shape);
    let mut felt = [FingerPrediction::Nothing; FINGERS];
    for (finger, prediction) in felt.iter_mut().enumerate() {
        *prediction = predict_finger(plan, &world_from_hand, finger, hypothesis, shape);
    }
    felt
}

fn predict_finger(
    plan: &TouchPlan,
    world_from_hand: &Isometry3<f32>,
    finger: usize,
    hypothesis: &PlanarPose,
    shape: &ObjectShape,
) -> FingerPrediction {
    let object_from_hand = hypothesis.isometry(shape.rest_height_m()).inverse() * world_from_hand;
    let mut inner_rad = plan.preopen_rad[finger];
    let at = |angle_rad: f32| {
        let mut angles = plan.preopen_rad;
        angles[finger] = angle_rad;
        nearest_link(&object_from_hand, &HandAngles::engaged(angles, plan.spread_rad), finger, shape)
    };
    let Some((_, first)) = at(inner_rad) else { return FingerPrediction::Nothing };
    if first.distance_m < -LANDED_M {
        return FingerPrediction::Landed;
    }
    if !plan.closes[finger] {
        return FingerPrediction::Nothing;
    }
    let mut distance_m = first.distance_m;
    for _ in 0..STEPS_MAX {
        let step_rad = (distance_m / REACH_M).max(STEP_MIN_RAD);
        inner_rad += step_rad;
        if inner_rad > CLOSE_END_RAD {
            return FingerPrediction::Nothing;
        }
        let Some((link, found)) = at(inner_rad) else { return FingerPrediction::Nothing };
        if found.distance_m < TOUCH_M {
            // Between the last two angles the separation passes zero: interpolate.
            let fall_m = distance_m - found.distance_m;
            let back = if fall_m > 0.0 { (-found.distance_m / fall_m).clamp(0.0, 1.0) } else { 0.0 };
            let gradient = found.gradient_world(libm::sincosf(hypothesis.phi_rad));
            return FingerPrediction::Contact { inner_rad: inner_rad - back * step_rad, link, gradient };
        }
        distance_m = found.distance_m;
    }
    FingerPrediction::Nothing
}

/// The link of a finger (knuckle, inner, tip) that is nearest to the object.
fn nearest_link(
    object_from_hand: &Isometry3<f32>,
    angles: &HandAngles,
    finger: usize,
    shape: &ObjectShape,
) -> Option<(HandLink, Separation)> {
    let poses = hand::link_poses(object_from_hand, angles);
    let mut nearest: Option<(HandLink, Separation)> = None;
    for (link, pose) in HandLink::ALL.iter().zip(poses).rev() {
        if link.finger() != Some(finger) {
            continue;
        }
        let limit_m = nearest.as_ref().map_or(f32::INFINITY, |(_, s)| s.distance_m);
        let bound_m = shape.separation_lower_bound_m(&pose, hand_prism(*link));
        if bound_m < limit_m
            && let Some(s) = shape.separation_below(&pose, hand_prism(*link), limit_m)
        {
            nearest = Some((*link, s));
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touch::candidate;

    const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;

    #[test]
    fn at_the_predicted_onset_the_predicted_link_just_touches() {
        let (believed, truth) = (PlanarPose::new(0.2, -0.1, 0.3), PlanarPose::new(0.21, -0.11, 0.2));
        for id in 0..crate::touch::CANDIDATES {
            let plan = candidate(id, &SHAPE).expect("listed");
            for (finger, felt) in predict(&plan, &believed, &truth, &SHAPE).iter().enumerate() {
                let FingerPrediction::Contact { inner_rad, link, .. } = felt else { continue };
                let hand = truth.isometry(SHAPE.rest_height_m()).inverse() * plan.world_from_hand(&believed, &SHAPE);
                let mut inner = plan.preopen_rad;
                inner[finger] = *inner_rad;
                let poses = hand::link_poses(&hand, &HandAngles::engaged(inner, plan.spread_rad));
                let gap = SHAPE.separation(&poses[link.index()], hand_prism(*link)).expect("finite").distance_m;
                assert!(gap.abs() < 1.5e-4, "{id} F{}: {gap}", finger + 1);
            }
        }
    }

    #[test]
    fn a_box_that_is_not_there_is_not_felt() {
        let plan = candidate(0, &SHAPE).expect("listed");
        let away = PlanarPose::new(0.6, 0.0, 0.0);
        assert_eq!(predict(&plan, &PlanarPose::default(), &away, &SHAPE), [FingerPrediction::Nothing; 3]);
    }

    #[test]
    fn a_finger_over_the_top_face_lands() {
        let plan = candidate(0, &SHAPE).expect("listed");
        // F1 and F2 stand on the +y side of the believed box; the true one reaches under them.
        let felt = predict(&plan, &PlanarPose::default(), &PlanarPose::new(0.0, 0.08, 0.0), &SHAPE);
        assert_eq!(felt[0], FingerPrediction::Landed);
        assert_eq!(felt[1], FingerPrediction::Landed);
        assert_ne!(felt[2], FingerPrediction::Landed);
    }
}
