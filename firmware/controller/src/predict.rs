//! Kinematic predictor: what the hand would feel if the object stood at a hypothesised pose.
//!
//! Closes the modelled fingers on the shape, TorqueSwitch engaged, until a link touches: conservative advancement
//! (a step never longer than the separation over the fastest point's speed), so nothing is jumped over.

use crate::touch::TouchPlan;
use crate::work::{POSES, Work};
use tactus_common::limits::FINGERS;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::{self, ENGAGED_RATIO};
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
const STEPS_MAX: u8 = 48;

/// What foretells the readings of a touch, for the errors that compare contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PredictorKind {
    /// The modelled fingers close on the shape, in the controller: [`Predictor`].
    #[default]
    Kinematic,
    /// The mental world rolls the touch out, asked over the wire.
    Simulation,
}

impl PredictorKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Kinematic, Self::Simulation];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kinematic => "kinematic",
            Self::Simulation => "simulation",
        }
    }

    /// The one with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

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
    let mut predictor = Predictor::default();
    predictor.begin(plan, believed, hypothesis, shape);
    predictor.open(shape, &mut Work::unlimited());
    predictor.close(shape, &mut Work::unlimited());
    predictor.felt
}

/// A finger on its way.
#[derive(Clone, Copy, Debug, Default)]
struct Finger {
    /// Object-from-knuckle transform.
    knuckle: Isometry3<f32>,
    /// Lower bound of the knuckle's separation, metres; infinite where the palm stands for it.
    knuckle_bound_m: f32,
    /// Inner angle, radians.
    inner_rad: f32,
    /// Separation of the nearest link there, metres; none for numbers that are none.
    distance_m: Option<f32>,
    steps: u8,
}

/// A prediction under way, in slices: first the open hand ([`Self::open`]), then the closing ([`Self::close`]), all with
/// the shape that it was begun with.
#[derive(Clone, Debug, Default)]
pub struct Predictor {
    sin_cos_phi: (f32, f32),
    closes: [bool; FINGERS],
    fingers: [Finger; FINGERS],
    opened: usize,
    closed: usize,
    felt: Prediction,
}

impl Predictor {
    /// Begins the prediction of the touch `plan`, aimed at an object believed at `believed`, that stands at
    /// `hypothesis`.
    pub fn begin(&mut self, plan: &TouchPlan, believed: &PlanarPose, hypothesis: &PlanarPose, shape: &ObjectShape) {
        self.begin_at(plan, &plan.world_from_hand(believed, shape), hypothesis, shape);
    }

    /// The same with the hand at `world_from_hand`, wherever the touch was aimed: that it was measured there, say.
    pub fn begin_at(
        &mut self,
        plan: &TouchPlan,
        world_from_hand: &Isometry3<f32>,
        hypothesis: &PlanarPose,
        shape: &ObjectShape,
    ) {
        let object_from_hand = hypothesis.isometry(shape.rest_height_m()).inverse() * world_from_hand;
        self.sin_cos_phi = libm::sincosf(hypothesis.phi_rad);
        self.closes = plan.closes;
        let fingers = self.fingers.iter_mut().zip(HandLink::KNUCKLES).enumerate();
        for ((index, (finger, link)), inner_rad) in fingers.zip(plan.preopen_rad) {
            let knuckle = hand::knuckle_pose(&object_from_hand, index, plan.spread_rad);
            let knuckle_bound_m = match link {
                Some(link) => shape.separation_lower_bound_m(&knuckle, hand_prism(link)),
                None => f32::INFINITY,
            };
            *finger = Finger { knuckle, knuckle_bound_m, inner_rad, distance_m: None, steps: 0 };
        }
        (self.opened, self.closed) = (0, 0);
        self.felt = [FingerPrediction::Nothing; FINGERS];
    }

    /// Which fingers come down on the object. `true` once that is known of all.
    pub fn open(&mut self, shape: &ObjectShape, work: &mut Work) -> bool {
        while let Some((finger, felt)) = self.fingers.get_mut(self.opened).zip(self.felt.get_mut(self.opened)) {
            if !work.is_left_for(shape) {
                return false;
            }
            finger.distance_m = finger.nearest(self.opened, shape, work).map(|(_, found)| found.distance_m);
            if finger.distance_m.is_some_and(|distance_m| distance_m < -LANDED_M) {
                *felt = FingerPrediction::Landed;
            }
            self.opened += 1;
        }
        true
    }

    /// After [`Self::open`]: closes the fingers that have not landed. `true` once all have come to their end.
    pub fn close(&mut self, shape: &ObjectShape, work: &mut Work) -> bool {
        while let Some((finger, felt)) = self.fingers.get_mut(self.closed).zip(self.felt.get_mut(self.closed)) {
            if *felt != FingerPrediction::Landed && self.closes.get(self.closed) == Some(&true) {
                loop {
                    if !work.is_left_for(shape) {
                        return false;
                    }
                    if let Some(end) = finger.step(self.closed, shape, self.sin_cos_phi, work) {
                        *felt = end;
                        break;
                    }
                }
            }
            self.closed += 1;
        }
        true
    }

    /// What has been predicted so far.
    pub fn felt(&self) -> &Prediction {
        &self.felt
    }
}

impl Finger {
    /// One step of the closing; `Some` at its end.
    fn step(
        &mut self,
        index: usize,
        shape: &ObjectShape,
        sin_cos_phi: (f32, f32),
        work: &mut Work,
    ) -> Option<FingerPrediction> {
        let Some(distance_m) = self.distance_m.filter(|_| self.steps < STEPS_MAX) else {
            return Some(FingerPrediction::Nothing);
        };
        self.steps += 1;
        let step_rad = (distance_m / REACH_M).max(STEP_MIN_RAD);
        self.inner_rad += step_rad;
        if self.inner_rad > CLOSE_END_RAD {
            return Some(FingerPrediction::Nothing);
        }
        let Some((link, found)) = self.nearest(index, shape, work) else { return Some(FingerPrediction::Nothing) };
        self.distance_m = Some(found.distance_m);
        if found.distance_m >= TOUCH_M {
            return None;
        }
        // Between the last two angles the separation passes zero: interpolate.
        let fall_m = distance_m - found.distance_m;
        let back = if fall_m > 0.0 { (-found.distance_m / fall_m).clamp(0.0, 1.0) } else { 0.0 };
        let gradient = found.gradient_world(sin_cos_phi);
        Some(FingerPrediction::Contact { inner_rad: self.inner_rad - back * step_rad, link, gradient })
    }

    /// The link of the finger (knuckle, inner, tip) that is nearest to the object.
    fn nearest(&self, index: usize, shape: &ObjectShape, work: &mut Work) -> Option<(HandLink, Separation)> {
        let distal_rad = ENGAGED_RATIO * self.inner_rad;
        let [inner_pose, tip_pose] = hand::finger_poses(&self.knuckle, index, self.inner_rad, distal_rad)?;
        let (inner, tip) = (*HandLink::INNERS.get(index)?, *HandLink::TIPS.get(index)?);
        // Tips touch most often, so they come first: what is known to be farther is not worked out.
        work.spend(POSES + shape.separation_cost());
        let mut nearest = shape.separation(&tip_pose, hand_prism(tip)).map(|found| (tip, found));
        let mut look = |link: HandLink, pose: &Isometry3<f32>, bound_m: f32| {
            let limit_m = nearest.as_ref().map_or(f32::INFINITY, |(_, found)| found.distance_m);
            if bound_m < limit_m {
                work.spend(shape.separation_cost());
                if let Some(found) = shape.separation_below(pose, hand_prism(link), limit_m) {
                    nearest = Some((link, found));
                }
            }
        };
        look(inner, &inner_pose, shape.separation_lower_bound_m(&inner_pose, hand_prism(inner)));
        if let Some(Some(knuckle)) = HandLink::KNUCKLES.get(index).copied() {
            look(knuckle, &self.knuckle, self.knuckle_bound_m);
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touch::candidate;
    use tactus_common::robot::hand::HandAngles;

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

    #[test]
    fn slicing_changes_nothing() {
        let (believed, truth) = (PlanarPose::new(0.2, -0.1, 0.3), PlanarPose::new(0.21, -0.11, 0.2));
        for id in 0..crate::touch::CANDIDATES {
            let plan = candidate(id, &SHAPE).expect("listed");
            let mut sliced = Predictor::default();
            sliced.begin(&plan, &believed, &truth, &SHAPE);
            while !sliced.open(&SHAPE, &mut Work::units(1)) {}
            while !sliced.close(&SHAPE, &mut Work::units(1)) {}
            assert_eq!(*sliced.felt(), predict(&plan, &believed, &truth, &SHAPE));
        }
    }
}
