//! Our own method with a limited number of evaluations: looks at the starts first, then searches and polishes from the
//! best of them, one after the other, until an end explains the evidence or no further search fits into the limit.

use super::gather::{is_same, sort_by_error};
use super::{ENDS_MAX, Evidence, Phase, Update};
use crate::error::{Geometric, GeometricConfig};
use crate::evidence::EvidenceStore;
use crate::optimise::{Found, LevenbergMarquardtConfig, Optimiser, StopReason};
use crate::work::{GATHERING, Work};

/// One evaluation in so many goes to looking at starts.
const SCREEN_SHARE: u16 = 4;
/// Evaluations that are kept for polishing while a search seeks.
const POLISH_RESERVE: u16 = 6;
/// A search that may evaluate less than this is not begun.
const SEEK_LEAST: u16 = 6;
/// A step below this ends a seeking search, metres: polishing goes on from there.
const SEEK_STEP_MIN_M: f32 = 3e-4;
/// An end explains the evidence if its error is at most this for each contact, in chi-squared units.
const EXPLAINED: f32 = 1.0;

impl Update {
    fn evaluations_left(&self) -> u16 {
        self.config.evaluations_max.saturating_sub(self.stats.evaluations)
    }

    /// Starts that are looked at: those that the whole method would search from, as far as the limit allows.
    fn screened(&self) -> u16 {
        let all = (self.old.len() as u16 + self.starts).min(ENDS_MAX as u16);
        (self.config.evaluations_max / SCREEN_SHARE).max(1).min(all)
    }

    pub(super) fn start_screening(&mut self) {
        self.phase = Phase::Screen { next: 0 };
    }

    /// One evaluation of a start, or what the work allows of it.
    pub(super) fn screen(&mut self, next: u16, wide: &GeometricConfig, store: &EvidenceStore, work: &mut Work) {
        if next >= self.screened() {
            sort_by_error(&mut self.ends);
            work.spend(GATHERING);
            self.start_seeking(0);
            return;
        }
        let pose = self.start(next);
        let wide = Geometric::new(store, &self.prior.shape, wide);
        let under_way = self.evaluation.get_or_insert_with(|| wide.begin(&pose));
        if let Some(evaluation) = wide.proceed(under_way, work) {
            self.evaluation = None;
            self.stats.evaluations = self.stats.evaluations.saturating_add(1);
            let _ = self.ends.push(Found { pose, evaluation });
            self.phase = Phase::Screen { next: next + 1 };
        }
    }

    /// Searches from the start of this rank, or ends.
    fn start_seeking(&mut self, rank: usize) {
        let most = self.evaluations_left().saturating_sub(POLISH_RESERVE).min(self.config.search.evaluations_max);
        match self.ends.get(rank).copied() {
            Some(start) if most >= SEEK_LEAST || (rank == 0 && most > 0) => {
                let seek = LevenbergMarquardtConfig {
                    // The start's own evaluation comes on top: it is known already.
                    evaluations_max: most + 1,
                    step_min_m: SEEK_STEP_MIN_M,
                    ..self.config.search
                };
                self.begin_search(seek, &start.pose);
                // What is known of the start needs no second look.
                self.search.tell(&start.evaluation);
                self.phase = Phase::Seek { rank };
            }
            _ => {
                if rank < self.ends.len() {
                    self.stats.stop = Some(StopReason::EvaluationLimit);
                }
                if let (true, Some(best)) = (self.polished.is_empty(), self.ends.first()) {
                    let _ = self.polished.push(*best);
                }
                self.finish_polishing();
            }
        }
    }

    pub(super) fn finish_seeking(&mut self, rank: usize, found: Found) {
        let symmetry_rad = self.prior.shape.yaw_symmetry_rad();
        let is_known = self.ends.iter().take(rank).any(|end| is_same(&end.pose, &found.pose, symmetry_rad));
        if let Some(end) = self.ends.get_mut(rank) {
            *end = found;
        }
        let most = self.evaluations_left().min(self.config.search.evaluations_max);
        if is_known || most == 0 {
            self.start_seeking(rank + 1);
        } else {
            let refine = LevenbergMarquardtConfig { evaluations_max: most, ..self.config.search };
            self.begin_search(refine, &found.pose);
            self.phase = Phase::Refine { rank };
        }
    }

    pub(super) fn finish_refining(&mut self, rank: usize, found: Found, evidence: &Evidence<'_>, work: &mut Work) {
        if self.polished.is_full() {
            sort_by_error(&mut self.polished);
            self.polished.pop();
        }
        let _ = self.polished.push(found);
        work.spend(GATHERING);
        let contacts = evidence.store.contacts().len() as f32;
        if found.evaluation.error <= EXPLAINED * contacts {
            self.finish_polishing();
        } else {
            self.start_seeking(rank + 1);
        }
    }
}
