//! The method that an experiment is about: which error, which formulation, which optimiser.

use super::capture::{CapturedUpdate, repeat};
use super::search::{Searched, search};
use clap::ValueEnum;
use serde_json::{Value, json};
use tactus_common::pose::PlanarPose;
use tactus_controller::error::contact::ContactError;
use tactus_controller::error::{ErrorFunction, Evaluation, Geometric, GeometricConfig};
use tactus_controller::optimise::{Gradient, Method as Optimiser, SearchOptions, StopReason};
use tactus_controller::update::UpdateConfig;

/// Which error function.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// Contacts foretold and felt, compared (Nikandrova 2011, eq. 21).
    Contact,
    /// The same, the first difference weighs most (eq. 23).
    Weighted,
    /// The same, and the angles of the closed hand (eq. 24).
    Modified,
    /// Distances of touching and free links from the object's surface.
    Geometric,
}

impl ErrorKind {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Geometric, Self::Modified, Self::Weighted, Self::Contact];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Weighted => "weighted",
            Self::Modified => "modified",
            Self::Geometric => "geometric",
        }
    }

    /// The published error, if it is one.
    pub fn published(self) -> Option<ContactError> {
        match self {
            Self::Contact => Some(ContactError::Mismatch),
            Self::Weighted => Some(ContactError::Weighted),
            Self::Modified => Some(ContactError::Modified),
            Self::Geometric => None,
        }
    }
}

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
    /// The error.
    pub error: ErrorKind,
    /// What is repeated.
    pub formulation: Formulation,
    /// What minimises it. With the geometric error, Levenberg-Marquardt means the controller's own update: several
    /// starts under a wide loss, then the narrow one.
    pub optimizer: Optimiser,
    /// Budget, gradients, goal.
    pub options: SearchOptions,
    /// `a` of eq. 22, instants.
    pub damping: f32,
    /// Rows of the contact matrices.
    pub instants: usize,
}

impl Method {
    /// The controller's own update.
    pub fn is_default(&self) -> bool {
        self.error == ErrorKind::Geometric && self.optimizer == Optimiser::LevenbergMarquardt
    }

    /// All that its results depend on.
    pub fn settings(&self) -> Value {
        let mut settings = json!({
            "error": self.error.name(),
            "formulation": self.formulation.name(),
            "optimizer": self.optimizer.name(),
            "evaluations_max": self.options.evaluations_max,
        });
        if !self.is_default() {
            settings["gradient"] = json!(self.options.gradient.name());
        }
        if self.error.published().is_some() {
            settings["damping"] = json!(self.damping);
            settings["instants"] = json!(self.instants);
            settings["goal_error"] = json!(self.options.goal_error);
            settings["sensors"] = json!("ideal");
            settings["predictor"] = json!("simulation");
        }
        settings
    }

    /// Searches the pose that explains the evidence before an update best, from `start`.
    pub fn search_fixed(&self, update: &CapturedUpdate, start: &PlanarPose) -> Searched {
        if self.is_default() {
            return default_search(update, self.options.evaluations_max);
        }
        let bounds = update.prior.bounds();
        search(self.optimizer, start, &bounds, &self.options, self.fixed_error(update))
    }

    /// The error of poses, given the evidence before an update.
    pub fn fixed_error<'a>(&self, update: &'a CapturedUpdate) -> impl Fn(&PlanarPose) -> Evaluation + Sync + 'a {
        let config = GeometricConfig { loss_scale: 30.0, ..GeometricConfig::default() };
        let geometric = Geometric::new(&update.evidence, &update.prior.shape, &config);
        move |pose| geometric.evaluate(pose)
    }
}

/// The controller's update from the prior, on all evidence at once.
fn default_search(update: &CapturedUpdate, _evaluations_max: u16) -> Searched {
    let (belief, stats, time) = repeat(update, &UpdateConfig::default());
    Searched {
        pose: belief.pose(),
        error: stats.error,
        evaluations: u32::from(stats.evaluations),
        time_s: time.as_secs_f64(),
        reason: StopReason::Converged,
    }
}

/// The gradient of a name.
///
/// # Errors
/// There is none; the message lists them.
pub fn gradient(name: &str) -> Result<Gradient, String> {
    Gradient::from_name(name).ok_or_else(|| expected(Gradient::ALL.map(Gradient::name)))
}

/// The optimiser of a name.
///
/// # Errors
/// There is none; the message lists them.
pub fn optimizer(name: &str) -> Result<Optimiser, String> {
    Optimiser::from_name(name).ok_or_else(|| expected(Optimiser::ALL.map(Optimiser::name)))
}

fn expected<const N: usize>(names: [&str; N]) -> String {
    format!("expected one of {}", names.join(", "))
}
