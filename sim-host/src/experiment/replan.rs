//! The published formulation "replan": for every hypothesis the touch is planned anew and made in both worlds, and the
//! readings are compared (Nikandrova 2011, section on the error function; eqs. 21-24).
//!
//! Every evaluation asks for a trial, so it can be done in simulation only. In both worlds the hand is held where the
//! planned trajectory would bring it and closes there; the arm's way to that place is planned, but not driven.

use crate::advisor;
use crate::mental::{Closing as Order, MentalModel, RolloutInput, RolloutOutcome};
use crate::mission::Reality;
use crate::plan::{PlanRefusal, Planner, PlannerConfig};
use crate::scenario::Scenario;
use crate::world::{HandStart, Scene};
use std::time::{Duration, Instant};
use tactus_common::limits::FINGERS;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::source;
use tactus_common::shape::ObjectShape;
use tactus_controller::error::PublishedConfig;
use tactus_controller::error::contact::{Closing, ContactMatrix};
use tactus_controller::touch::{CLOSED_RAD, TouchPlan, candidate};

/// Ticks of a rollout: 1.2 s, slow enough to leave the object where it is.
const ROLLOUT_TICKS: u32 = 600;
/// Its length, seconds.
const ROLLOUT_S: f32 = ROLLOUT_TICKS as f32 * tactus_common::limits::TICK_S;

/// Why a pose has no error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unevaluable {
    /// No way to the touch.
    #[error("{0}")]
    Plan(#[from] PlanRefusal),
    /// The object cannot be simulated there.
    #[error("cannot be simulated")]
    Rollout,
}

/// What one evaluation gave and cost.
#[derive(Clone, Copy, Debug)]
pub struct Replanned {
    /// The error, or why there is none.
    pub error: Result<f32, Unevaluable>,
    /// Wall time of the trial in the simulated reality.
    pub trial: Duration,
    /// Wall time of planning and of the mental rollout.
    pub mental: Duration,
}

/// The two worlds and what is compared.
pub struct Replan {
    planner: Planner,
    mental: MentalModel,
    reality: MentalModel,
    shape: ObjectShape,
    truth: PlanarPose,
    touch: TouchPlan,
    published: PublishedConfig,
}

impl Replan {
    /// Worlds with the object of a scene, in reality at `truth`, among the scene's obstacles.
    ///
    /// # Errors
    /// The robot description cannot be used.
    pub fn new(
        scenario: &Scenario,
        truth: PlanarPose,
        reality: Reality,
        seed: u64,
        published: PublishedConfig,
    ) -> anyhow::Result<Self> {
        let shape = scenario.shape();
        let obstacles = scenario.known_obstacles();
        let touch = candidate(0, &shape).ok_or_else(|| anyhow::anyhow!("no touch for this object"))?;
        Ok(Self {
            planner: Planner::new(
                &urdf_rs::read_from_string(source::URDF)?,
                PlannerConfig::default(),
                &scenario.robot_base,
                &obstacles,
            )?,
            mental: scenario.mental_model()?,
            reality: MentalModel::of(&reality.mismatch(scenario, seed))?.among(&obstacles),
            shape,
            truth,
            touch,
            published,
        })
    }

    /// The error of the hypothesis that the object stands at `pose`.
    pub fn evaluate(&self, pose: &PlanarPose) -> Replanned {
        let mut replanned =
            Replanned { error: Err(Unevaluable::Rollout), trial: Duration::ZERO, mental: Duration::ZERO };
        let started = Instant::now();
        let start_q_rad = Scene::default().arm_start_rad;
        if let Err(refusal) = advisor::plan_touch(&self.planner, &self.touch, &start_q_rad, pose, &self.shape) {
            replanned.error = Err(refusal.into());
            replanned.mental = started.elapsed();
            return replanned;
        }
        let predicted = self.close(&self.mental, pose, pose);
        replanned.mental = started.elapsed();
        let started = Instant::now();
        let felt = self.close(&self.reality, pose, &self.truth);
        replanned.trial = started.elapsed();
        if let (Some(predicted), Some(felt)) = (predicted, felt) {
            replanned.error = Ok(self.published.between(&predicted, &felt));
        }
        replanned
    }

    /// What a closing planned for an object at `planned` feels like in a world with it at `object`.
    fn close(&self, world: &MentalModel, planned: &PlanarPose, object: &PlanarPose) -> Option<Closing> {
        let input = RolloutInput {
            world_from_hand: self.touch.world_from_hand(planned, &self.shape),
            start: HandStart { inner_rad: self.touch.preopen_rad, spread_rad: self.touch.spread_rad },
            closing: Order::Together,
            speed_rad_s: self.touch.preopen_rad.map(|open_rad| (CLOSED_RAD - open_rad) / ROLLOUT_S),
            stop_at_rad: CLOSED_RAD,
            ticks: ROLLOUT_TICKS,
            object: *object,
            shape: self.shape,
        };
        Some(closing(&world.rollout(&input).ok()?))
    }
}

/// A rollout as the published errors see it: contacts at equally spaced instants, and the angles at the end.
fn closing(rollout: &RolloutOutcome) -> Closing {
    Closing {
        contacts: ContactMatrix::new(rollout.touched_by_instant(ROLLOUT_TICKS as usize)),
        inner_rad: rollout.samples.last().map_or([0.0; FINGERS], |sample| sample.inner_rad),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: PlanarPose = PlanarPose::new(0.2, -0.1, 0.0);

    fn replan(reality: Reality) -> Replan {
        Replan::new(&Scenario::thesis_box(), TRUTH, reality, 1, PublishedConfig::default()).unwrap()
    }

    #[test]
    fn worlds_that_are_alike_agree_at_the_truth_and_differ_the_more_the_farther_the_guess() {
        let replan = replan(Reality::Nominal);
        let error = |y_m: f32| replan.evaluate(&PlanarPose::new(0.2, y_m, 0.0)).error.unwrap();
        assert_eq!(error(-0.1), 0.0);
        assert!(error(-0.09) > 0.0 && error(-0.06) > error(-0.09), "{} {}", error(-0.09), error(-0.06));
    }

    #[test]
    fn a_pose_out_of_reach_is_named_and_has_no_error() {
        let replan = replan(Reality::Nominal);
        assert_eq!(
            replan.evaluate(&PlanarPose::new(0.9, 0.3, 0.0)).error,
            Err(Unevaluable::Plan(PlanRefusal::OutOfReach))
        );
    }
}
