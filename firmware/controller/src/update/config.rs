//! How an update goes about it, and how that is told by name.

use crate::error::{ErrorKind, GeometricConfig, PublishedConfig};
use crate::optimise::{Gradient, LevenbergMarquardtConfig, Method, SearchOptions};
use crate::predict::PredictorKind;
use tactus_common::message::ROLLOUT_INSTANTS;
use tactus_common::method::Method as Told;

/// Parameters of an update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpdateConfig {
    /// What residuals are worth.
    pub geometric: GeometricConfig,
    /// Each single search of our own method.
    pub search: LevenbergMarquardtConfig,
    /// What is minimised.
    pub error: ErrorKind,
    /// How.
    pub optimiser: Method,
    /// What foretells the readings, for the published errors.
    pub predictor: PredictorKind,
    /// Where slopes come from.
    pub gradient: Gradient,
    /// Damping constant of the weighted errors in instants, greater than 0.
    pub damping: f32,
    /// Instants that the published errors compare, 1 to [`ROLLOUT_INSTANTS`].
    pub instants: u8,
    /// A search for a published error ends below this for each touch; the published criterion is 1 (Nikandrova 2011).
    pub goal_error: f32,
    /// Most evaluations of one update; 0: as many as our own method takes, and for another its own default.
    pub evaluations_max: u16,
}

impl Default for UpdateConfig {
    /// Our own method: geometric error, Levenberg-Marquardt from several starts, analytic slope, no limit.
    fn default() -> Self {
        let published = PublishedConfig::default();
        Self {
            geometric: GeometricConfig::default(),
            search: LevenbergMarquardtConfig::default(),
            error: ErrorKind::default(),
            optimiser: Method::LevenbergMarquardt,
            predictor: PredictorKind::default(),
            gradient: Gradient::default(),
            damping: published.damping,
            instants: published.instants,
            goal_error: 1.0,
            evaluations_max: 0,
        }
    }
}

impl UpdateConfig {
    /// What a mission is told; `None` for a name that is in none of the lists, or a number that makes no sense.
    pub fn of(told: &Told) -> Option<Self> {
        let is_damping = told.damping.is_finite() && told.damping > 0.0;
        let is_count = (1..=ROLLOUT_INSTANTS).contains(&usize::from(told.instants));
        if !is_damping || !is_count {
            return None;
        }
        Some(Self {
            error: ErrorKind::from_name(told.error.as_str())?,
            optimiser: Method::from_name(told.optimizer.as_str())?,
            predictor: PredictorKind::from_name(told.predictor.as_str())?,
            gradient: Gradient::from_name(told.gradient.as_str())?,
            damping: told.damping,
            instants: told.instants,
            evaluations_max: told.evaluations_max,
            ..Self::default()
        })
    }

    /// Is it our own method: explore and polish with the geometric error's own slope?
    pub fn is_ours(&self) -> bool {
        self.error == ErrorKind::Geometric
            && self.optimiser == Method::LevenbergMarquardt
            && self.gradient == Gradient::Analytic
    }

    /// Options of one search by another optimiser, or for another error, over this many touches. The published search ends
    /// where the published criterion is met.
    pub fn search_options(&self, touches: usize) -> SearchOptions {
        let defaults = SearchOptions::default();
        let is_published = self.published().is_some();
        SearchOptions {
            evaluations_max: match self.evaluations_max {
                0 => defaults.evaluations_max,
                most if is_published => most,
                // One is for the covariance.
                most => most - 1,
            },
            goal_error: if is_published { self.goal_error * touches as f32 } else { 0.0 },
            gradient: self.gradient,
            ..defaults
        }
    }

    /// The published error that is minimised, if it is one.
    pub fn published(&self) -> Option<PublishedConfig> {
        let error = self.error.published()?;
        Some(PublishedConfig { error, damping: self.damping, instants: self.instants })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_common::name::Name;

    #[test]
    fn what_is_told_by_default_is_our_own_method() {
        let config = UpdateConfig::of(&Told::default()).expect("known");
        assert_eq!(config, UpdateConfig::default());
        assert!(config.is_ours());
    }

    #[test]
    fn what_is_not_in_the_lists_or_makes_no_sense_is_refused() {
        let magic = Name::new("magic").expect("a name");
        let odd: [fn(&mut Told, Name); 8] = [
            |t, magic| t.error = magic,
            |t, magic| t.optimizer = magic,
            |t, magic| t.predictor = magic,
            |t, magic| t.gradient = magic,
            |t, _| t.damping = 0.0,
            |t, _| t.damping = f32::NAN,
            |t, _| t.instants = 0,
            |t, _| t.instants = ROLLOUT_INSTANTS as u8 + 1,
        ];
        for spoil in odd {
            let mut told = Told::default();
            spoil(&mut told, magic);
            assert_eq!(UpdateConfig::of(&told), None, "{told:?}");
        }
    }
}
