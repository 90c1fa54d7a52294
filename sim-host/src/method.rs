//! How the pose is to be found, as the command line says it.

use crate::mission::Reality;
use anyhow::ensure;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use tactus_common::message::ROLLOUT_INSTANTS;
use tactus_common::method::Method;
use tactus_common::name::Name;
use tactus_controller::error::ErrorKind;
use tactus_controller::optimise::{self, Gradient};
use tactus_controller::predict::PredictorKind;

/// The flags that choose the method, for every command that carries missions out.
#[derive(Args, Debug, Clone)]
pub struct MethodArgs {
    /// How many components of the pose are uncertain: 1 = x, 2 = x and y, 3 = x, y and phi.
    #[arg(long, value_name = "1|2|3", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=3))]
    pub dof: u8,
    /// Contact sensors: `real` = the hand's own; `ideal` = besides, one bit per link.
    #[arg(long, value_enum, default_value_t = Sensors::Real)]
    pub sensors: Sensors,
    /// Error that the update minimises; all but `geometric` need `--sensors ideal`.
    #[arg(long, value_name = "NAME", default_value = ErrorKind::Geometric.name(), value_parser = error_parser())]
    pub error: ErrorKind,
    /// Optimiser that minimises it; an unknown one is refused with the list.
    #[arg(long, value_name = "NAME", default_value = optimise::Method::LevenbergMarquardt.name(), value_parser = optimizer)]
    pub optimizer: optimise::Method,
    /// What foretells the readings for the errors that compare contacts.
    #[arg(long, value_name = "NAME", default_value = PredictorKind::Kinematic.name(), value_parser = predictor_parser())]
    pub predictor: PredictorKind,
    /// Where slopes come from; `analytic` = the error's own where it has one, two-sided differences where not.
    #[arg(long, value_name = "NAME", default_value = Gradient::Analytic.name(), value_parser = gradient_parser())]
    pub gradient: Gradient,
    /// Damping constant of the weighted errors, in instants.
    #[arg(long, value_name = "A", default_value_t = Method::DEFAULT.damping)]
    pub damping: f32,
    /// Time instants of the contact matrices.
    #[arg(long, value_name = "N", default_value_t = Method::DEFAULT.instants, value_parser = clap::value_parser!(u8).range(1..=ROLLOUT_INSTANTS as i64))]
    pub instants: u8,
    /// Most evaluations of the error in one update; 0 = the method's own default.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub evaluations: u16,
    /// How reality differs from the model: `mismatched` by seed and with noise, or `nominal`.
    #[arg(long, value_enum, default_value_t = Reality::Mismatched)]
    pub reality: Reality,
    /// Most touches before giving up.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u8).range(1..=8))]
    pub max_trials: u8,
}

/// Parses the name of an error.
pub fn error_parser() -> impl TypedValueParser<Value = ErrorKind> {
    PossibleValuesParser::new(ErrorKind::ALL.map(ErrorKind::name))
        .try_map(|name| ErrorKind::from_name(&name).ok_or("no such error"))
}

/// Parses the name of a predictor.
pub fn predictor_parser() -> impl TypedValueParser<Value = PredictorKind> {
    PossibleValuesParser::new(PredictorKind::ALL.map(PredictorKind::name))
        .try_map(|name| PredictorKind::from_name(&name).ok_or("no such predictor"))
}

/// Parses the name of a gradient.
pub fn gradient_parser() -> impl TypedValueParser<Value = Gradient> {
    PossibleValuesParser::new(Gradient::ALL.map(Gradient::name))
        .try_map(|name| Gradient::from_name(&name).ok_or("no such gradient"))
}

/// The optimiser of a name. They are many: only who asks for one that does not exist is told them all.
///
/// # Errors
/// There is none; the message lists them.
pub fn optimizer(name: &str) -> Result<optimise::Method, String> {
    let known = || optimise::Method::ALL.map(optimise::Method::name).join(", ");
    optimise::Method::from_name(name).ok_or_else(|| format!("no optimiser of that name; expected one of: {}", known()))
}

/// Refuses a damping constant that cannot be one.
///
/// # Errors
/// One line that names it.
pub fn check_damping(damping: f32) -> anyhow::Result<()> {
    ensure!(
        damping.is_finite() && damping > 0.0,
        "--damping {damping}: expected a finite number of instants above zero"
    );
    Ok(())
}

/// Contact sensors of the hand.
#[derive(ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sensors {
    /// The hand's own.
    #[default]
    Real,
    /// Besides, a contact sensor for each link, which the real hand lacks.
    Ideal,
}

impl Sensors {
    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Real => "real",
            Self::Ideal => "ideal",
        }
    }
}

/// How the pose is to be found, and with which sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MethodOptions {
    /// What the controller is told.
    pub method: Method,
    /// The world's contact sensors.
    pub sensors: Sensors,
}

impl MethodOptions {
    /// The controller's own method; the ideal sensors tell of every touch, for other methods to be tried on.
    pub fn with_ideal_sensors() -> Self {
        Self { sensors: Sensors::Ideal, ..Self::default() }
    }
}

impl MethodArgs {
    /// The flags, checked.
    ///
    /// # Errors
    /// One line: an unknown optimiser, a number that makes no sense, an error without the sensors that it needs.
    pub fn options(&self) -> anyhow::Result<MethodOptions> {
        check_damping(self.damping)?;
        ensure!(
            self.error == ErrorKind::Geometric || self.sensors == Sensors::Ideal,
            "--error {} --sensors {}: needs --sensors ideal (it compares the contacts of every link, which the real hand \
             does not feel)",
            self.error.name(),
            self.sensors.name()
        );
        let as_name = |text: &str| Name::new(text).ok_or_else(|| anyhow::anyhow!("{text}: not a name"));
        let method = Method {
            error: as_name(self.error.name())?,
            optimizer: as_name(self.optimizer.name())?,
            predictor: as_name(self.predictor.name())?,
            gradient: as_name(self.gradient.name())?,
            damping: self.damping,
            instants: self.instants,
            evaluations_max: self.evaluations,
        };
        Ok(MethodOptions { method, sensors: self.sensors })
    }
}
