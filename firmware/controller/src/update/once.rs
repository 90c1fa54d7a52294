//! One search by any optimiser, for any error: the published method, and others to compare ours with.

use super::{Evidence, Phase, Update};
use crate::error::geometric::{self, Geometric};
use crate::error::published::{self, Published};
use crate::error::{Evaluation, GeometricConfig, PublishedConfig};
use crate::evidence::EvidenceStore;
use crate::felt_touch::FeltTouch;
use crate::optimise::{AnyOptimiser, Ask, Found, Optimiser};
use crate::predict::PredictorKind;
use crate::work::{GATHERING, Work};
use tactus_common::message::{RolloutRequest, RolloutResult};
use tactus_common::pose::PlanarPose;

/// An evaluation under way.
#[derive(Clone, Debug)]
enum Evaluating {
    Geometric(geometric::UnderWay),
    Published(published::UnderWay),
    /// One rollout of the mental world after the other.
    RollingOut {
        pose: PlanarPose,
        /// The touch that is asked about.
        touch: usize,
        error: f32,
    },
}

/// The search; its optimiser takes 6.7 kB and stays where it is.
#[derive(Clone, Debug, Default)]
pub(super) struct Once {
    optimiser: Option<AnyOptimiser>,
    evaluating: Option<Evaluating>,
}

impl Once {
    pub(super) fn forget(&mut self) {
        self.optimiser = None;
        self.evaluating = None;
    }
}

impl Update {
    /// What the mental world must be asked before the update can go on; the same until it is answered. `None` if
    /// nothing: only with the simulation as predictor is there anything to ask. `touches` as in [`Self::step`].
    pub fn question(&self, touches: &[FeltTouch]) -> Option<RolloutRequest> {
        match &self.once.evaluating {
            Some(Evaluating::RollingOut { pose, touch, .. }) => touches.get(*touch).map(|felt| felt.question(pose)),
            Some(Evaluating::Geometric(_) | Evaluating::Published(_)) | None => None,
        }
    }

    /// The answer to [`Self::question`].
    pub fn answer(&mut self, touches: &[FeltTouch], foretold: &RolloutResult) {
        let config = self.config.published();
        if let (Some(config), Some(Evaluating::RollingOut { touch, error, .. })) = (config, &mut self.once.evaluating)
            && let Some(felt) = touches.get(*touch)
        {
            *error += config.between(&felt.rolled_out(foretold), &felt.felt);
            *touch += 1;
        }
    }

    /// Does the pose found explain what was felt, by the criterion of the published errors: less than 1 for each touch
    /// (Nikandrova 2011)? `None` for the geometric error, whose belief knows better.
    pub fn explains(&self, touches: &[FeltTouch]) -> Option<bool> {
        self.config.published()?;
        Some(self.once.optimiser.is_some() && self.stats.error < touches.len() as f32)
    }

    /// One evaluation of the search, or what the work allows of it.
    pub(super) fn search_once(&mut self, wide: &GeometricConfig, evidence: &Evidence<'_>, work: &mut Work) {
        let published = self.config.published();
        if self.once.optimiser.is_none() {
            if published.is_some() && evidence.touches.is_empty() {
                // Nothing to compare: the belief stays.
                self.phase = Phase::Done;
                return;
            }
            self.create_optimiser(evidence.touches);
            work.spend(GATHERING);
        }
        let Some(optimiser) = &mut self.once.optimiser else {
            // Not compiled in: the belief stays. A set-up that asks for it is refused before.
            self.phase = Phase::Done;
            return;
        };
        let wide = Geometric::new(evidence.store, &self.prior.shape, wide);
        let evaluation = match &mut self.once.evaluating {
            None => match optimiser.ask() {
                Ask::Evaluate(pose) => {
                    self.once.evaluating = Some(self.begin_evaluation(pose, published, &wide, evidence));
                    return;
                }
                Ask::Done(found, reason) => {
                    self.stats.stop = Some(reason);
                    self.finish_once(&found, published.is_some(), work);
                    return;
                }
            },
            Some(Evaluating::Geometric(under_way)) => wide.proceed(under_way, work),
            Some(Evaluating::Published(under_way)) => {
                let config = published.unwrap_or_default();
                Published::new(evidence.touches, &self.prior.shape, &config).proceed(under_way, work)
            }
            // Every touch is answered: otherwise there were a question.
            Some(Evaluating::RollingOut { error, .. }) => Some(Evaluation { error: *error, slope: None }),
        };
        if let Some(evaluation) = evaluation {
            self.once.evaluating = None;
            self.stats.evaluations = self.stats.evaluations.saturating_add(1);
            optimiser.tell(&evaluation);
            // Between evaluations some sort all that they know.
            work.spend(GATHERING);
        }
    }

    /// A function of its own, so that the kilobytes of stack on which an optimiser is made are free again before the first
    /// evaluation.
    #[inline(never)]
    fn create_optimiser(&mut self, touches: &[FeltTouch]) {
        let (from, options) = (self.belief.pose(), self.config.search_options(touches.len()));
        self.once.optimiser = AnyOptimiser::new(self.config.optimiser, &from, &self.bounds, &options);
    }

    fn begin_evaluation(
        &self,
        pose: PlanarPose,
        published: Option<PublishedConfig>,
        wide: &Geometric<'_>,
        evidence: &Evidence<'_>,
    ) -> Evaluating {
        match (published, self.config.predictor) {
            (None, _) => Evaluating::Geometric(wide.begin(&pose)),
            (Some(_), PredictorKind::Simulation) => Evaluating::RollingOut { pose, touch: 0, error: 0.0 },
            (Some(config), PredictorKind::Kinematic) => {
                Evaluating::Published(Published::new(evidence.touches, &self.prior.shape, &config).begin(&pose))
            }
        }
    }

    fn finish_once(&mut self, found: &Found, is_published: bool, work: &mut Work) {
        work.spend(GATHERING);
        if is_published {
            self.gather_published(found);
            self.phase = Phase::Done;
        } else {
            self.phase = Phase::Narrow(found.pose);
        }
    }

    /// The end of the search under the narrow loss: it has the covariance.
    pub(super) fn look_narrowly(
        &mut self,
        pose: &PlanarPose,
        narrow: &GeometricConfig,
        store: &EvidenceStore,
        work: &mut Work,
    ) {
        let narrow = Geometric::new(store, &self.prior.shape, narrow);
        let under_way = self.evaluation.get_or_insert_with(|| narrow.begin(pose));
        if let Some(evaluation) = narrow.proceed(under_way, work) {
            self.evaluation = None;
            self.stats.evaluations = self.stats.evaluations.saturating_add(1);
            let _ = self.polished.push(Found { pose: *pose, evaluation });
            self.phase = Phase::Check;
        }
    }
}
