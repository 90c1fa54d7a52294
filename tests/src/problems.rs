//! Pose updates without physics: evidence as the kinematic predictor foretells it, with noise, from a seed.
//!
//! What optimisers are compared on and what is counted: all methods get the same stored evidence, bounds and start.

use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::robot::hand::HandAngles;
use tactus_common::shape::ObjectShape;
use tactus_controller::belief::Prior;
use tactus_controller::error::{Geometric, GeometricConfig};
use tactus_controller::evidence::{ContactKind, EvidenceStore, Toucher};
use tactus_controller::predict::{CLOSE_END_RAD, FingerPrediction, Prediction, predict};
use tactus_controller::touch::{TouchPlan, candidate};
use tactus_sim_host::world::noise::Noise;

/// The touches, as numbers of candidates: across the box, on both ends, across it again 40 mm beside.
pub const TOUCHES: [u8; 3] = [0, 6, 3];
/// Where the object is thought to stand.
pub const GUESS: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.0 };
/// How wrong that may be.
pub const INTERVAL: Interval = Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 };
/// Standard deviation of a contact along the finger's way, metres.
pub const NOISE_M: f32 = 0.3e-3;
/// Way of a fingertip for a turn of its inner link, metres per radian: from the joint to the middle of the pad, the tip
/// bent by a third.
const LEVER_M: f32 = 0.1;
/// Seed of the first problem.
const SEED: u64 = 2011;

/// A pose to be found.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Where the object stands.
    pub truth: PlanarPose,
    /// What is known beforehand: the bounds of all searches, and their start.
    pub prior: Prior,
    /// What was felt.
    pub evidence: EvidenceStore,
}

impl Problem {
    /// What residuals are worth: contacts are predicted exactly at the surface, so none is late.
    pub fn config() -> GeometricConfig {
        GeometricConfig { contact_depth_m: 0.0, ..GeometricConfig::default() }
    }

    /// What all optimisers minimise: the loss of an update's exploring searches, which pulls from afar.
    pub fn error(&self) -> Geometric<'_> {
        Geometric::new(&self.evidence, &self.prior.shape, &Self::config().wide())
    }

    /// Distance of `pose` from the truth in the plane, metres.
    pub fn location_error_m(&self, pose: &PlanarPose) -> f64 {
        f64::from(pose.x_m - self.truth.x_m).hypot(f64::from(pose.y_m - self.truth.y_m))
    }
}

/// `count` problems, the same on every machine. Truths are uniform over the interval but for those where a finger would
/// come down on the object, which is another matter than closing on it.
///
/// # Panics
/// If a candidate is not listed or its evidence finds no room: the list is a constant, and so is the room.
pub fn seeded(count: usize) -> Vec<Problem> {
    let shape = ObjectShape::THESIS_BOX;
    let prior = Prior { guess: GUESS, interval: INTERVAL, shape };
    let plans = TOUCHES.map(|id| candidate(id, &shape).expect("candidates of these numbers are listed"));
    let mut random = Noise::new(SEED);
    let mut problems = Vec::new();
    // Five offsets in six are taken; an end is sure, whatever becomes of the candidates.
    for _ in 0..1000 * count {
        if problems.len() == count {
            break;
        }
        let truth = PlanarPose::new(
            GUESS.x_m + INTERVAL.x_m * random.symmetric(),
            GUESS.y_m + INTERVAL.y_m * random.symmetric(),
            GUESS.phi_rad + INTERVAL.phi_rad * random.symmetric(),
        );
        let felt = plans.map(|plan| predict(&plan, &GUESS, &truth, &shape));
        if felt.iter().flatten().any(|finger| *finger == FingerPrediction::Landed) {
            continue;
        }
        let mut evidence = EvidenceStore::new(shape.top_height_m());
        for (plan, felt) in plans.iter().zip(&felt) {
            record(&mut evidence, plan, felt, &shape, &mut random);
        }
        problems.push(Problem { truth, prior, evidence });
    }
    assert_eq!(problems.len(), count, "almost every offset makes a finger land");
    problems
}

/// What the touch `plan` felt becomes evidence.
fn record(evidence: &mut EvidenceStore, plan: &TouchPlan, felt: &Prediction, shape: &ObjectShape, random: &mut Noise) {
    let room = "three touches fill no store";
    evidence.begin_touch();
    let hand = plan.world_from_hand(&GUESS, shape);
    let open = HandAngles::engaged(plan.preopen_rad, plan.spread_rad);
    evidence.add_free(&hand, &open, [true; 3]).expect(room);
    for (finger, felt) in felt.iter().enumerate() {
        match felt {
            FingerPrediction::Contact { inner_rad, .. } => {
                let mut inner = plan.preopen_rad;
                inner[finger] = inner_rad + random.normal() * (NOISE_M / LEVER_M);
                let angles = HandAngles::engaged(inner, plan.spread_rad);
                evidence.add_contact(&hand, &angles, Toucher::Finger(finger), ContactKind::Closing).expect(room);
            }
            FingerPrediction::Nothing if plan.closes[finger] => {
                evidence.add_free_sweep(&hand, &open, finger, CLOSE_END_RAD).expect(room);
            }
            FingerPrediction::Nothing | FingerPrediction::Landed => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_controller::error::ErrorFunction;

    #[test]
    fn problems_are_the_same_each_time_and_a_longer_list_begins_alike() {
        let (few, many) = (seeded(3), seeded(5));
        for (a, b) in few.iter().zip(&many) {
            assert_eq!(a.truth, b.truth);
            assert_eq!(a.error().evaluate(&GUESS), b.error().evaluate(&GUESS));
        }
    }

    #[test]
    fn the_truth_explains_the_evidence_but_for_the_noise_and_the_guess_does_not() {
        for problem in seeded(10) {
            assert!(!problem.evidence.contacts().is_empty());
            let (at_truth, at_guess) =
                (problem.error().evaluate(&problem.truth).error, problem.error().evaluate(&GUESS).error);
            assert!(at_truth < 3.0 * problem.evidence.contacts().len() as f32, "{at_truth}");
            assert!(at_guess > 10.0 * at_truth, "{at_guess} at the guess, {at_truth} at the truth");
        }
    }
}
