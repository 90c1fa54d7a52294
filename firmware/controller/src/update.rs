//! Update: from evidence to belief, by a multi-start search that is sliced over ticks.
//!
//! Explore: from each start (the old modes, then a low-discrepancy sequence over the prior's region) a search under a
//! wide loss, which pulls from afar. Polish: the distinct ends again under the narrow loss, which lets go of late or
//! false contacts. Probe: where the error does not rise about an end as its covariance says, a valley goes on, and the
//! pose there is an end as well. Gather: the ends within a chi-squared margin are the modes; ends along a flat valley
//! stay apart, so that their spread enters the covariance.

mod config;
mod gather;
mod limited;
mod once;
mod probe;

pub use config::UpdateConfig;

use crate::belief::{Belief, MODES_MAX, Prior};
use crate::error::geometric::{Geometric, GeometricConfig, ResidualsUnderWay, UnderWay};
use crate::evidence::EvidenceStore;
use crate::felt_touch::FeltTouch;
use crate::optimise::{Ask, Bounds, Found, LevenbergMarquardt, LevenbergMarquardtConfig, Optimiser, StopReason, start};
use crate::work::{GATHERING, MATRICES, Work};
use gather::{merge, sort_by_error};
use heapless::Vec;
use once::Once;
use probe::Probe;
use tactus_common::pose::PlanarPose;

/// Modes of the old belief from which a search starts.
const OLD_MODES_MAX: usize = MODES_MAX;
/// Starts over the region when it is small / large.
const STARTS_SMALL: u16 = 8;
const STARTS_LARGE: u16 = 16;
/// A region with a half width beyond these is large: about the clearance beside open fingers, and 30 degrees.
const LARGE_POSITION_M: f32 = 0.06;
const LARGE_YAW_RAD: f32 = 0.52;
/// Ends kept for polishing.
const ENDS_MAX: usize = OLD_MODES_MAX + STARTS_LARGE as usize;

/// All that was felt.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// Contacts and free links, for the geometric error.
    pub store: &'a EvidenceStore,
    /// Felt touches, for the published errors.
    pub touches: &'a [FeltTouch],
}

impl<'a> From<&'a EvidenceStore> for Evidence<'a> {
    /// Evidence for the geometric error alone.
    fn from(store: &'a EvidenceStore) -> Self {
        Self { store, touches: &[] }
    }
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateStats {
    /// Evaluations of the error, all searches together.
    pub evaluations: u16,
    /// Searches.
    pub searches: u16,
    /// Modes found.
    pub modes: u8,
    /// Least error: in chi-squared units, or of the published error over all touches.
    pub error: f32,
    /// Why the (last) search ended.
    pub stop: Option<StopReason>,
}

/// State of an update after a slice of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// More to do.
    Running,
    /// [`Update::belief`] holds the result.
    Done,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Phase {
    Explore {
        next: u16,
    },
    Polish {
        next: usize,
    },
    /// With few evaluations: looks at the starts.
    Screen {
        next: u16,
    },
    /// With few evaluations: searches from the start of this rank, under the wide loss.
    Seek {
        rank: usize,
    },
    /// With few evaluations: polishes what came of it.
    Refine {
        rank: usize,
    },
    /// One search by another optimiser or for another error.
    Once,
    /// The end of that search under the narrow loss.
    Narrow(PlanarPose),
    /// Whether the error rises about the ends as their covariances say.
    Probe(Probe),
    /// How well the best end explains the evidence.
    Check,
    #[default]
    Done,
}

/// One update; owns all its state, about 11 KiB.
#[derive(Clone, Debug, Default)]
pub struct Update {
    config: UpdateConfig,
    prior: Prior,
    bounds: Bounds,
    old: Vec<PlanarPose, OLD_MODES_MAX>,
    starts: u16,
    phase: Phase,
    search: LevenbergMarquardt,
    /// The evaluation that the search waits for.
    evaluation: Option<UnderWay>,
    residuals: Option<ResidualsUnderWay>,
    ends: Vec<Found, ENDS_MAX>,
    polished: Vec<Found, MODES_MAX>,
    /// Ends about which the error is probed.
    probed: usize,
    /// The pose whose error is being probed.
    probe_pose: PlanarPose,
    once: Once,
    stats: UpdateStats,
    belief: Belief,
}

impl Update {
    /// An update of the belief `before` on all evidence; nothing is evaluated yet.
    pub fn new(prior: &Prior, before: &Belief, config: &UpdateConfig) -> Self {
        let mut update = Self::default();
        update.begin(prior, before, config);
        update
    }

    /// Begins an update anew, in place.
    pub fn begin(&mut self, prior: &Prior, before: &Belief, config: &UpdateConfig) {
        self.config = *config;
        self.prior = *prior;
        self.bounds = prior.bounds();
        self.old.clear();
        if before.residuals().contacts > 0 {
            for mode in before.modes().iter().take(OLD_MODES_MAX) {
                let _ = self.old.push(mode.pose);
            }
        }
        let interval = prior.interval;
        let is_large = interval.x_m.max(interval.y_m) > LARGE_POSITION_M || interval.phi_rad > LARGE_YAW_RAD;
        self.starts = if is_large { STARTS_LARGE } else { STARTS_SMALL };
        self.ends.clear();
        self.polished.clear();
        self.stats = UpdateStats::default();
        self.belief.clone_from(before);
        (self.evaluation, self.residuals) = (None, None);
        self.once.forget();
        if !config.is_ours() {
            self.stats.searches = 1;
            self.phase = Phase::Once;
        } else if config.evaluations_max > 0 {
            self.start_screening();
        } else {
            self.start_exploring(0);
        }
    }

    /// The belief: the old one until the update is done.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// What was done so far.
    pub fn stats(&self) -> UpdateStats {
        self.stats
    }

    /// As much as the work allows. The evidence must be the same in every slice of one update. With the simulation as
    /// predictor it goes on once [`Self::question`] has been [answered](Self::answer).
    pub fn step<'a>(&mut self, work: &mut Work, evidence: impl Into<Evidence<'a>>) -> Progress {
        let evidence = evidence.into();
        let store = evidence.store;
        let narrow = self.config.geometric;
        let wide = narrow.wide();
        while work.is_left_for(&self.prior.shape) {
            match self.phase {
                Phase::Explore { .. } | Phase::Seek { .. } => self.search(&wide, &evidence, work),
                Phase::Polish { .. } | Phase::Refine { .. } => self.search(&narrow, &evidence, work),
                Phase::Screen { next } => self.screen(next, &wide, store, work),
                Phase::Once if self.question(evidence.touches).is_some() => return Progress::Running,
                Phase::Once => self.search_once(&wide, &evidence, work),
                Phase::Narrow(pose) => self.look_narrowly(&pose, &narrow, store, work),
                Phase::Probe(probe) => self.probe(probe, &narrow, store, work),
                Phase::Check => self.check(&narrow, store, work),
                Phase::Done => return Progress::Done,
            }
        }
        if self.phase == Phase::Done { Progress::Done } else { Progress::Running }
    }

    /// One evaluation of the search under way, or what the work allows of it.
    fn search(&mut self, config: &GeometricConfig, evidence: &Evidence<'_>, work: &mut Work) {
        let error = Geometric::new(evidence.store, &self.prior.shape, config);
        match (self.evaluation.as_mut(), self.search.ask()) {
            (Some(under_way), _) => {
                if let Some(evaluation) = error.proceed(under_way, work) {
                    self.evaluation = None;
                    self.stats.evaluations = self.stats.evaluations.saturating_add(1);
                    self.search.tell(&evaluation);
                    work.spend(MATRICES);
                }
            }
            (None, Ask::Evaluate(pose)) => self.evaluation = Some(error.begin(&pose)),
            (None, Ask::Done(found, reason)) => {
                self.stats.stop = Some(reason);
                self.finish_search(found, evidence, work);
            }
        }
    }

    fn start_exploring(&mut self, index: u16) {
        let from = self.start(index);
        self.begin_search(self.config.search, &from);
        self.phase = Phase::Explore { next: index + 1 };
    }

    /// The old modes, then the sequence over the region.
    fn start(&self, index: u16) -> PlanarPose {
        match self.old.get(usize::from(index)) {
            Some(pose) => *pose,
            None => self.bounds.at(start(index - self.old.len() as u16)),
        }
    }

    fn begin_search(&mut self, config: LevenbergMarquardtConfig, from: &PlanarPose) {
        self.stats.searches += 1;
        self.search = LevenbergMarquardt::new(&config, &self.bounds, from);
    }

    fn finish_search(&mut self, found: Found, evidence: &Evidence<'_>, work: &mut Work) {
        match self.phase {
            Phase::Explore { next } => {
                let _ = self.ends.push(found);
                if usize::from(next) < self.old.len() + usize::from(self.starts) {
                    self.start_exploring(next);
                } else {
                    sort_by_error(&mut self.ends);
                    merge(&mut self.ends, self.prior.shape.yaw_symmetry_rad());
                    work.spend(GATHERING);
                    self.start_polishing(0);
                }
            }
            Phase::Polish { next } => {
                let _ = self.polished.push(found);
                self.start_polishing(next);
            }
            Phase::Seek { rank } => self.finish_seeking(rank, found),
            Phase::Refine { rank } => self.finish_refining(rank, found, evidence, work),
            Phase::Screen { .. } | Phase::Once | Phase::Narrow(_) | Phase::Probe(_) | Phase::Check | Phase::Done => {}
        }
    }

    fn start_polishing(&mut self, index: usize) {
        match self.ends.get(index) {
            Some(end) if index < MODES_MAX => {
                let pose = end.pose;
                self.begin_search(self.config.search, &pose);
                self.phase = Phase::Polish { next: index + 1 };
            }
            _ => self.finish_polishing(),
        }
    }

    fn finish_polishing(&mut self) {
        self.order_polished();
        self.start_probing();
    }

    fn finish_probing(&mut self) {
        self.order_polished();
        self.phase = Phase::Check;
    }

    fn order_polished(&mut self) {
        sort_by_error(&mut self.polished);
        merge(&mut self.polished, self.prior.shape.yaw_symmetry_rad());
    }

    /// Has the limit of evaluations, if there is one, not been reached yet?
    fn may_evaluate(&self) -> bool {
        self.config.evaluations_max == 0 || self.stats.evaluations < self.config.evaluations_max
    }

    /// How well the best end explains the evidence; then the belief follows. The old one stays if there is no end.
    fn check(&mut self, narrow: &GeometricConfig, store: &EvidenceStore, work: &mut Work) {
        let Some(best) = self.polished.first().copied() else {
            self.phase = Phase::Done;
            return;
        };
        let narrow = Geometric::new(store, &self.prior.shape, narrow);
        let under_way = self.residuals.get_or_insert_with(|| narrow.begin_residuals(&best.pose));
        if let Some(residuals) = narrow.proceed_residuals(under_way, work) {
            work.spend(GATHERING);
            self.gather(&best, residuals);
            self.phase = Phase::Done;
        }
    }
}

#[cfg(test)]
mod tests;
