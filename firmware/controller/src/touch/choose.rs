//! Choice of the next touch by the information that it is expected to give, sliced over ticks.
//!
//! Over samples of the belief, the predicted contacts' gradients `g` add `g g' / sigma^2` to the information about the
//! pose. The gain of a touch is the expected fall of `1/2 ln det(covariance + T)`, with T about the tolerance of the
//! grasp, so that knowing better than needed earns nothing; plus the entropy of whether each finger touches at all;
//! less a price for fingers that would come down on the object, and for repeating a touch.

use super::clear::Clearance;
use super::{CANDIDATES, TouchPlan, candidate};
use crate::belief::{Belief, Prior, SAMPLES_MAX};
use crate::predict::{FingerPrediction, Predictor};
use crate::sort::insertion_sort;
use crate::work::{MATRICES, Work};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};
use tactus_common::limits::FINGERS;
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;

/// Units in which covariances are compared: a standard deviation of this matters no more. Metres, metres, radians.
const SCALE: [f32; 3] = [1e-3, 1e-3, 0.0087];
/// Standard deviation of a contact, metres.
const CONTACT_SIGMA_M: f32 = 0.7e-3;
/// Price of a finger that comes down on the object, nats.
const LANDING_PRICE: f32 = 1.5;
/// Price of making a touch again from nearly the same place, nats.
const REPEAT_PRICE: f32 = 2.0;
/// Nearer than this is the same place, metres and radians.
const REPEAT_M: f32 = 0.01;
const REPEAT_RAD: f32 = 0.1;
/// Touches that a history remembers.
const HISTORY_MAX: usize = 16;

/// The touches that were made.
#[derive(Clone, Debug, Default)]
pub struct TouchHistory {
    made: Vec<(u8, PlanarPose), HISTORY_MAX>,
}

impl TouchHistory {
    /// Notes that candidate `id` was tried with the object believed at `believed`. The oldest is forgotten when full.
    pub fn note(&mut self, id: u8, believed: &PlanarPose) {
        if self.made.is_full() {
            self.made.remove(0);
        }
        let _ = self.made.push((id, *believed));
    }

    /// Number of touches remembered.
    pub fn len(&self) -> usize {
        self.made.len()
    }

    /// `true` before the first touch.
    pub fn is_empty(&self) -> bool {
        self.made.is_empty()
    }

    fn repeats(&self, id: u8, believed: &PlanarPose) -> usize {
        let is_near = |p: &PlanarPose| {
            libm::fabsf(p.x_m - believed.x_m) < REPEAT_M
                && libm::fabsf(p.y_m - believed.y_m) < REPEAT_M
                && libm::fabsf(p.phi_rad - believed.phi_rad) < REPEAT_RAD
        };
        self.made.iter().filter(|(made, pose)| *made == id && is_near(pose)).count()
    }
}

/// A touch with what it is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The touch.
    pub plan: TouchPlan,
    /// Expected information less prices, nats.
    pub gain: f32,
    /// Expected number of fingers that come down on the object.
    pub landings: f32,
}

/// All candidates, the best first: if the planner refuses one, take the next.
pub type RankedTouches = Vec<Choice, { CANDIDATES as usize }>;

/// Sums over the samples for one candidate.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    gain: f32,
    landings: f32,
    landing: f32,
    touching: [f32; FINGERS],
}

/// The choice under way. About 1.5 KiB.
#[derive(Clone, Debug, Default)]
pub struct Chooser {
    pub(super) shape: ObjectShape,
    believed: PlanarPose,
    samples: Vec<(PlanarPose, f32), SAMPLES_MAX>,
    /// Information of the belief in units of [`SCALE`].
    information: Matrix3<f32>,
    log_det_before: f32,
    /// How often each candidate was made from nearly here.
    repeats: [u8; CANDIDATES as usize],
    pub(super) ranked: RankedTouches,
    id: u8,
    sample: usize,
    /// The prediction of this candidate at this sample has begun.
    pub(super) predicting: bool,
    pub(super) predictor: Predictor,
    pub(super) clearance: Clearance,
    tally: Tally,
}

impl Chooser {
    /// A choice for a belief, after the touches in `history`.
    pub fn new(belief: &Belief, prior: &Prior, history: &TouchHistory) -> Self {
        let mut chooser = Self::default();
        chooser.begin(belief, prior, history);
        chooser
    }

    /// Begins a choice anew, in place.
    pub fn begin(&mut self, belief: &Belief, prior: &Prior, history: &TouchHistory) {
        let covariance = scaled(&belief.covariance());
        self.shape = prior.shape;
        self.believed = belief.pose();
        self.samples = belief.samples(&prior.bounds());
        self.information = inverse(&covariance);
        self.log_det_before = log_det_softened(&covariance);
        for (id, repeats) in (0..CANDIDATES).zip(&mut self.repeats) {
            *repeats = history.repeats(id, &self.believed) as u8;
        }
        self.ranked.clear();
        (self.id, self.sample, self.predicting) = (0, 0, false);
        self.clearance = Clearance::default();
        self.tally = Tally::default();
    }

    /// These candidates in this order, without a choice.
    pub fn begin_with(&mut self, ids: &[u8], shape: &ObjectShape) {
        self.shape = *shape;
        self.ranked.clear();
        for plan in ids.iter().filter_map(|id| candidate(*id, shape)) {
            let _ = self.ranked.push(Choice { plan, gain: 0.0, landings: 0.0 });
        }
        self.id = CANDIDATES;
        (self.predicting, self.clearance) = (false, Clearance::default());
    }

    /// What has been ranked: all candidates, the best first, once [`Self::step`] says so.
    pub fn ranked(&self) -> &RankedTouches {
        &self.ranked
    }

    /// Predicts candidates at samples, as far as the work allows. `Some` when all are ranked; then again the same.
    pub fn step(&mut self, work: &mut Work) -> Option<&RankedTouches> {
        while let Some(plan) = candidate(self.id, &self.shape) {
            if !work.is_left() {
                return None;
            }
            match self.samples.get(self.sample).copied() {
                Some((pose, weight)) => {
                    if !self.predicting {
                        self.predictor.begin(&plan, &self.believed, &pose, &self.shape);
                        self.predicting = true;
                        work.spend(MATRICES);
                    }
                    if !self.weigh(weight, work) {
                        return None;
                    }
                    self.predicting = false;
                    self.sample += 1;
                }
                None => {
                    self.finish_candidate(plan);
                    work.spend(MATRICES);
                }
            }
        }
        Some(&self.ranked)
    }

    /// Adds the sample under prediction to the tally of its candidate; `false` if the work did not suffice.
    fn weigh(&mut self, weight: f32, work: &mut Work) -> bool {
        if !self.predictor.open(&self.shape, work) {
            return false;
        }
        let landed = self.predictor.felt().iter().filter(|f| **f == FingerPrediction::Landed).count();
        if landed > 0 {
            // The hand goes back up: no finger closes.
            self.tally.landings += weight * landed as f32;
            self.tally.landing += weight;
            return true;
        }
        if !self.predictor.close(&self.shape, work) {
            return false;
        }
        work.spend(MATRICES);
        let mut information = self.information;
        for (prediction, touching) in self.predictor.felt().iter().zip(&mut self.tally.touching) {
            if let FingerPrediction::Contact { gradient, .. } = prediction {
                let g = Vector3::from_fn(|axis, _| gradient[axis] * SCALE[axis] / CONTACT_SIGMA_M);
                information += g * g.transpose();
                *touching += weight;
            }
        }
        let after = log_det_softened(&inverse(&information));
        self.tally.gain += weight * 0.5 * (self.log_det_before - after);
        true
    }

    fn finish_candidate(&mut self, plan: TouchPlan) {
        let tally = self.tally;
        let surprise = tally.touching.iter().map(|p| entropy(*p)).sum::<f32>() + entropy(tally.landing);
        let repeats = self.repeats.get(usize::from(plan.id)).map_or(0.0, |n| f32::from(*n));
        let gain = tally.gain + surprise - LANDING_PRICE * tally.landings - REPEAT_PRICE * repeats;
        let _ = self.ranked.push(Choice { plan, gain, landings: tally.landings });
        self.tally = Tally::default();
        self.sample = 0;
        self.id += 1;
        if self.id >= CANDIDATES {
            insertion_sort(&mut self.ranked, |a, b| b.gain.total_cmp(&a.gain).then(a.plan.id.cmp(&b.plan.id)));
        }
    }
}

/// A covariance in units of [`SCALE`]; components known exactly get a variance that is too small to matter.
fn scaled(covariance: &Matrix3<f32>) -> Matrix3<f32> {
    let mut scaled = Matrix3::from_fn(|row, column| covariance[(row, column)] / (SCALE[row] * SCALE[column]));
    for axis in 0..3 {
        scaled[(axis, axis)] += 1e-3;
    }
    scaled
}

/// Inverse of a positive definite matrix; zero if it is not.
fn inverse(m: &Matrix3<f32>) -> Matrix3<f32> {
    m.cholesky().map_or_else(Matrix3::zeros, |root| root.inverse())
}

/// `ln det(m + 1)`.
fn log_det_softened(m: &Matrix3<f32>) -> f32 {
    match (m + Matrix3::identity()).cholesky() {
        Some(root) => {
            let l = root.l();
            2.0 * (libm::logf(l[(0, 0)]) + libm::logf(l[(1, 1)]) + libm::logf(l[(2, 2)]))
        }
        None => 0.0,
    }
}

/// Entropy of a yes-no event, nats.
fn entropy(p: f32) -> f32 {
    let term = |q: f32| if q > 1e-6 { -q * libm::logf(q) } else { 0.0 };
    term(p) + term(1.0 - p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_common::pose::Interval;

    const PRIOR: Prior = Prior {
        guess: PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.0 },
        interval: Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 },
        shape: ObjectShape::THESIS_BOX,
    };

    fn rank(belief: &Belief, history: &TouchHistory) -> RankedTouches {
        let mut chooser = Chooser::new(belief, &PRIOR, history);
        chooser.step(&mut Work::unlimited()).expect("no end of work, so an end of the choice").clone()
    }

    #[test]
    fn slicing_changes_nothing() {
        let belief = Belief::from_prior(&PRIOR);
        let mut sliced = Chooser::new(&belief, &PRIOR, &TouchHistory::default());
        let slices = (0..100_000).find(|_| sliced.step(&mut Work::units(1)).is_some()).expect("an end");
        assert!(slices > 1_000, "thin slices: {slices}");
        assert_eq!(*sliced.ranked(), rank(&belief, &TouchHistory::default()));
    }

    #[test]
    fn every_candidate_is_ranked_best_first() {
        let ranked = rank(&Belief::from_prior(&PRIOR), &TouchHistory::default());
        assert_eq!(ranked.len(), CANDIDATES as usize);
        assert!(ranked.windows(2).all(|pair| pair[0].gain >= pair[1].gain));
        assert!(ranked[0].gain > 1.0);
    }

    #[test]
    fn a_touch_that_was_made_is_not_made_again_at_once() {
        let belief = Belief::from_prior(&PRIOR);
        let mut history = TouchHistory::default();
        let first = rank(&belief, &history)[0];
        history.note(first.plan.id, &belief.pose());
        history.note(first.plan.id, &belief.pose());
        let second = rank(&belief, &history)[0];
        assert_ne!(first.plan.id, second.plan.id);
    }

    #[test]
    fn what_is_known_across_the_box_makes_a_touch_of_its_ends_worth_more() {
        let bounds = PRIOR.bounds();
        let at = |dx: f32| PlanarPose { x_m: PRIOR.guess.x_m + dx, ..PRIOR.guess };
        let modes = [-0.04, -0.02, 0.0, 0.02, 0.04].map(|dx| crate::belief::Mode {
            pose: bounds.clamp(&at(dx)),
            covariance: Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-7, 1e-6)),
            weight: 0.0,
            error: 0.0,
        });
        let along = Belief::from_modes(modes.into_iter().collect(), Default::default()).expect("modes");
        let best = rank(&along, &TouchHistory::default())[0];
        assert!((6..=11).contains(&best.plan.id), "{best:?}");
    }
}
