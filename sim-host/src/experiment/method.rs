//! The method that an experiment is about: which error, which formulation, which optimiser.

use super::capture::CapturedUpdate;
use crate::advisor::roll_out;
use crate::mental::MentalModel;
use clap::ValueEnum;
use serde_json::{Value, json};
use tactus_common::pose::PlanarPose;
use tactus_controller::error::published::Published;
use tactus_controller::error::{ErrorFunction, Geometric};
use tactus_controller::felt_touch::FeltTouch;
use tactus_controller::predict::PredictorKind;
use tactus_controller::update::UpdateConfig;

/// What is repeated at each hypothesis.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// The touch is planned anew for each hypothesis and made in both worlds: a trial for each evaluation.
    Replan,
    /// The touches are made once; only what they would have felt like is foretold anew.
    Fixed,
}

impl Formulation {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Replan => "replan",
            Self::Fixed => "fixed",
        }
    }
}

/// A method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// What is repeated.
    pub formulation: Formulation,
    /// Error, optimiser, predictor and their parameters. With the geometric error, Levenberg-Marquardt and the analytic
    /// gradient: the controller's own update.
    pub config: UpdateConfig,
}

impl Method {
    /// All that its results depend on.
    pub fn settings(&self) -> Value {
        let config = &self.config;
        let mut settings = json!({
            "error": config.error.name(),
            "formulation": self.formulation.name(),
            "optimizer": config.optimiser.name(),
            "gradient": config.gradient.name(),
            "evaluations_max": config.evaluations_max,
        });
        if config.published().is_some() {
            settings["damping"] = json!(config.damping);
            settings["instants"] = json!(config.instants);
            settings["goal_error"] = json!(config.goal_error);
            settings["sensors"] = json!("ideal");
            let predictor = match self.formulation {
                Formulation::Replan => PredictorKind::Simulation,
                Formulation::Fixed => config.predictor,
            };
            settings["predictor"] = json!(predictor.name());
        }
        settings
    }

    /// The error of poses, given the evidence before an update.
    pub fn fixed_error<'a>(
        &self,
        update: &'a CapturedUpdate,
        mental: &'a MentalModel,
    ) -> Box<dyn Fn(&PlanarPose) -> f32 + Sync + 'a> {
        let shape = &update.prior.shape;
        let Some(published) = self.config.published() else {
            let geometric = Geometric::new(&update.evidence, shape, &self.config.geometric);
            return Box::new(move |pose| geometric.evaluate(pose).error);
        };
        match self.config.predictor {
            PredictorKind::Kinematic => {
                let kinematic = Published::new(&update.felt, shape, &published);
                Box::new(move |pose| kinematic.evaluate(pose).error)
            }
            PredictorKind::Simulation => Box::new(move |pose| {
                let foretold = |touch: &FeltTouch| {
                    let result = roll_out(mental, shape, &touch.question(pose), 0);
                    published.between(&touch.rolled_out(&result), &touch.felt)
                };
                update.felt.iter().map(foretold).sum()
            }),
        }
    }
}
