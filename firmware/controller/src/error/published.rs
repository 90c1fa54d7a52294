//! The published errors over the felt touches of a mission: `E(x) = sum_k E_k(x)` (Nikandrova 2011, eqs. 21-24).
//!
//! The formulation with fixed trials: what each touch felt is compared with what it would have felt with the object at the
//! hypothesised pose, the hand where it was measured. Here the kinematic predictor foretells it; for the mental world see
//! [`crate::update`], which asks for one rollout after the other.

use super::contact::{Closing, ContactError};
use super::{ErrorFunction, Evaluation};
use crate::felt_touch::FeltTouch;
use crate::predict::Predictor;
use crate::work::{MATRICES, Work};
use tactus_common::message::ROLLOUT_INSTANTS;
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;

/// Which error, and its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedConfig {
    /// Which of them.
    pub error: ContactError,
    /// Damping constant `a` of eq. 22 in instants, greater than 0.
    pub damping: f32,
    /// Instants that are compared, 1 to [`ROLLOUT_INSTANTS`].
    pub instants: u8,
}

impl Default for PublishedConfig {
    /// The modified error at all instants, `a` a quarter of them.
    fn default() -> Self {
        Self { error: ContactError::Modified, damping: 4.0, instants: ROLLOUT_INSTANTS as u8 }
    }
}

impl PublishedConfig {
    /// The error of one touch: what is foretold against what was felt.
    pub fn between(&self, foretold: &Closing, felt: &Closing) -> f32 {
        let instants = usize::from(self.instants);
        let thinned = |of: &Closing| Closing { contacts: of.contacts.thinned(instants), inner_rad: of.inner_rad };
        self.error.between(&thinned(foretold), &thinned(felt), self.damping)
    }
}

/// A published error with the kinematic predictor.
#[derive(Clone, Copy, Debug)]
pub struct Published<'a> {
    touches: &'a [FeltTouch],
    shape: &'a ObjectShape,
    config: PublishedConfig,
}

/// An evaluation under way: for [`Published::proceed`]. About 300 bytes.
#[derive(Clone, Debug)]
pub struct UnderWay {
    pose: PlanarPose,
    /// The touch that is being foretold.
    touch: usize,
    /// Its prediction has begun.
    predicting: bool,
    predictor: Predictor,
    error: f32,
}

impl<'a> Published<'a> {
    /// The error of poses of `shape` given these touches; 0 everywhere without any.
    pub fn new(touches: &'a [FeltTouch], shape: &'a ObjectShape, config: &PublishedConfig) -> Self {
        Self { touches, shape, config: *config }
    }

    /// Begins to evaluate the error at `pose`.
    pub fn begin(&self, pose: &PlanarPose) -> UnderWay {
        UnderWay { pose: *pose, touch: 0, predicting: false, predictor: Predictor::default(), error: 0.0 }
    }

    /// Goes on with an evaluation; `Some` at the end, without slope. The touches must be the same in every slice.
    pub fn proceed(&self, under_way: &mut UnderWay, work: &mut Work) -> Option<Evaluation> {
        while let Some(touch) = self.touches.get(under_way.touch) {
            if !work.is_left() {
                return None;
            }
            let predictor = &mut under_way.predictor;
            if !under_way.predicting {
                predictor.begin_at(&touch.carried_out(), &touch.world_from_hand, &under_way.pose, self.shape);
                under_way.predicting = true;
                work.spend(MATRICES);
            }
            if !predictor.open(self.shape, work) || !predictor.close(self.shape, work) {
                return None;
            }
            under_way.error += self.config.between(&touch.foretold(predictor.felt()), &touch.felt);
            work.spend(MATRICES);
            under_way.predicting = false;
            under_way.touch += 1;
        }
        // A pose that is no number would be foretold to feel nothing.
        let error = if under_way.pose.is_finite() { under_way.error } else { f32::INFINITY };
        Some(Evaluation { error, slope: None })
    }
}

impl ErrorFunction for Published<'_> {
    fn evaluate(&self, pose: &PlanarPose) -> Evaluation {
        let mut under_way = self.begin(pose);
        // Without a limit there is always an end.
        let nothing = Evaluation { error: f32::INFINITY, slope: None };
        self.proceed(&mut under_way, &mut Work::unlimited()).unwrap_or(nothing)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::touch::{candidate, rehearse::rehearse_felt};

    const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;
    const AIM: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.1 };
    const TRUTH: PlanarPose = PlanarPose { x_m: 0.21, y_m: -0.09, phi_rad: 0.2 };
    const ERRORS: [ContactError; 3] = [ContactError::Mismatch, ContactError::Weighted, ContactError::Modified];

    fn touches(ids: &[u8]) -> std::vec::Vec<FeltTouch> {
        let touch = |id: &u8| rehearse_felt(&candidate(*id, &SHAPE).expect("listed"), &AIM, &TRUTH, &SHAPE);
        ids.iter().map(touch).collect()
    }

    #[test]
    fn the_truth_explains_what_it_caused_and_poses_far_off_do_not() {
        let felt = touches(&[0, 6]);
        for error in ERRORS {
            let error = Published::new(&felt, &SHAPE, &PublishedConfig { error, ..PublishedConfig::default() });
            assert_eq!(error.evaluate(&TRUTH).error, 0.0);
            for off in [[0.0, 0.03, 0.0], [0.0, 0.0, 0.3], [-0.04, 0.0, 0.0]] {
                let pose = PlanarPose::new(TRUTH.x_m + off[0], TRUTH.y_m + off[1], TRUTH.phi_rad + off[2]);
                assert!(error.evaluate(&pose).error >= 1.0, "{off:?}");
            }
            assert_eq!(error.evaluate(&PlanarPose::new(f32::NAN, 0.0, 0.0)).error, f32::INFINITY);
        }
    }

    #[test]
    fn the_errors_of_the_touches_add_up_and_slicing_changes_nothing() {
        let felt = touches(&[1, 7, 10]);
        let config = PublishedConfig { instants: 8, damping: 2.0, ..PublishedConfig::default() };
        let all = Published::new(&felt, &SHAPE, &config);
        for index in 0..20 {
            let unit = crate::optimise::start(index);
            let pose = PlanarPose::new(0.15 + 0.1 * unit[0], -0.15 + 0.1 * unit[1], -0.2 + 0.6 * unit[2]);
            let sum: f32 = felt
                .iter()
                .map(|touch| Published::new(core::slice::from_ref(touch), &SHAPE, &config).evaluate(&pose).error)
                .sum();
            let whole = all.evaluate(&pose);
            assert!((whole.error - sum).abs() < 1e-4, "{} {sum}", whole.error);
            let mut under_way = all.begin(&pose);
            let sliced = (0..10_000).find_map(|_| all.proceed(&mut under_way, &mut Work::units(1)));
            assert_eq!(sliced, Some(whole));
        }
    }

    #[test]
    fn without_touches_nothing_is_wrong_anywhere() {
        let error = Published::new(&[], &SHAPE, &PublishedConfig::default());
        assert_eq!(error.evaluate(&TRUTH), Evaluation { error: 0.0, slope: None });
    }
}
