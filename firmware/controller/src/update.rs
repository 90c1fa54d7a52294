//! Update: from evidence to belief, by a multi-start search that is sliced over ticks.
//!
//! Explore: from each start (the old modes, then a low-discrepancy sequence over the prior's region) a search under a
//! wide loss, which pulls from afar. Polish: the distinct ends again under the narrow loss, which lets go of late or
//! false contacts. Gather: the ends within a chi-squared margin are the modes; ends along a flat valley stay apart, so
//! that their spread enters the covariance.

use crate::belief::{Belief, MODES_MAX, Mode, Prior};
use crate::error::Evaluation;
use crate::error::geometric::{Geometric, GeometricConfig, Residuals, ResidualsUnderWay, UnderWay};
use crate::evidence::EvidenceStore;
use crate::optimise::{Ask, Bounds, Found, LevenbergMarquardt, LevenbergMarquardtConfig, Optimiser, start};
use crate::sort::insertion_sort;
use crate::work::{GATHERING, MATRICES, Work};
use heapless::Vec;
use nalgebra::Matrix3;
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
/// Ends closer than this are one.
const SAME_POSITION_M: f32 = 1.5e-3;
const SAME_YAW_RAD: f32 = 0.015;
/// Error above the least, in chi-squared units, up to which an end is a mode: 99.7 % for three components.
const MODE_MARGIN: f32 = 14.0;
/// Loss scale of the exploring searches, in standard deviations: 15 mm at 0.5 mm.
const WIDE_LOSS_SCALE: f32 = 30.0;
/// Least standard deviations that are ever claimed: errors of the model that all contacts share (size of the box,
/// kinematics of the hand) do not average out.
const FLOOR_POSITION_M: f32 = 0.3e-3;
const FLOOR_YAW_RAD: f32 = 2e-3;

/// Parameters of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateConfig {
    /// What residuals are worth.
    pub geometric: GeometricConfig,
    /// Each single search.
    pub search: LevenbergMarquardtConfig,
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
    /// Least error, in chi-squared units.
    pub error: f32,
}

/// State of an update after a slice of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// More to do.
    Running,
    /// [`Update::belief`] holds the result.
    Done,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    Explore {
        next: u16,
    },
    Polish {
        next: usize,
    },
    /// How well the best end explains the evidence.
    Check,
    #[default]
    Done,
}

/// One update; owns all its state, about 6 KiB.
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
        self.start_exploring(0);
    }

    /// The belief: the old one until the update is done.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// What was done so far.
    pub fn stats(&self) -> UpdateStats {
        self.stats
    }

    /// As much as the work allows. The evidence must be the same in every slice of one update.
    pub fn step(&mut self, work: &mut Work, store: &EvidenceStore) -> Progress {
        let narrow = self.config.geometric;
        let wide = GeometricConfig { loss_scale: WIDE_LOSS_SCALE, ..narrow };
        let narrow = Geometric::new(store, &self.prior.shape, &narrow);
        let wide = Geometric::new(store, &self.prior.shape, &wide);
        while work.is_left() {
            match self.phase {
                Phase::Explore { .. } => self.search(&wide, work),
                Phase::Polish { .. } => self.search(&narrow, work),
                Phase::Check => self.check(&narrow, work),
                Phase::Done => return Progress::Done,
            }
        }
        if self.phase == Phase::Done { Progress::Done } else { Progress::Running }
    }

    /// One evaluation of the search under way, or what the work allows of it.
    fn search(&mut self, error: &Geometric<'_>, work: &mut Work) {
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
            (None, Ask::Done(found, _)) => self.finish_search(found, work),
        }
    }

    fn start_exploring(&mut self, index: u16) {
        let from = match self.old.get(usize::from(index)) {
            Some(pose) => *pose,
            None => self.bounds.at(start(index - self.old.len() as u16)),
        };
        self.begin_search(&from);
        self.phase = Phase::Explore { next: index + 1 };
    }

    fn begin_search(&mut self, from: &PlanarPose) {
        self.stats.searches += 1;
        self.search = LevenbergMarquardt::new(&self.config.search, &self.bounds, from);
    }

    fn finish_search(&mut self, found: Found, work: &mut Work) {
        match self.phase {
            Phase::Explore { next } => {
                let _ = self.ends.push(found);
                if usize::from(next) < self.old.len() + usize::from(self.starts) {
                    self.start_exploring(next);
                } else {
                    insertion_sort(&mut self.ends, |a, b| a.evaluation.error.total_cmp(&b.evaluation.error));
                    merge(&mut self.ends);
                    work.spend(GATHERING);
                    self.start_polishing(0);
                }
            }
            Phase::Polish { next } => {
                let _ = self.polished.push(found);
                self.start_polishing(next);
            }
            Phase::Check | Phase::Done => {}
        }
    }

    fn start_polishing(&mut self, index: usize) {
        match self.ends.get(index) {
            Some(end) if index < MODES_MAX => {
                let pose = end.pose;
                self.begin_search(&pose);
                self.phase = Phase::Polish { next: index + 1 };
            }
            _ => {
                insertion_sort(&mut self.polished, |a, b| a.evaluation.error.total_cmp(&b.evaluation.error));
                merge(&mut self.polished);
                self.phase = Phase::Check;
            }
        }
    }

    /// How well the best end explains the evidence; then the belief follows. The old one stays if there is no end.
    fn check(&mut self, narrow: &Geometric<'_>, work: &mut Work) {
        let Some(best) = self.polished.first().copied() else {
            self.phase = Phase::Done;
            return;
        };
        let under_way = self.residuals.get_or_insert_with(|| narrow.begin_residuals(&best.pose));
        if let Some(residuals) = narrow.proceed_residuals(under_way, work) {
            work.spend(GATHERING);
            self.gather(&best, residuals);
            self.phase = Phase::Done;
        }
    }

    /// The belief from the polished ends.
    fn gather(&mut self, best: &Found, residuals: Residuals) {
        let mut modes: Vec<Mode, MODES_MAX> = Vec::new();
        for end in &self.polished {
            if end.evaluation.error <= best.evaluation.error + MODE_MARGIN {
                let mode = Mode {
                    pose: end.pose,
                    covariance: self.covariance(&end.evaluation),
                    weight: 0.0,
                    error: end.evaluation.error,
                };
                let _ = modes.push(mode);
            }
        }
        self.stats.modes = modes.len() as u8;
        self.stats.error = best.evaluation.error;
        if let Some(belief) = Belief::from_modes(modes, residuals) {
            self.belief = belief;
        }
    }

    /// Inverse of the evidence's information plus the prior's, over the components that are not known exactly, plus
    /// the floor.
    fn covariance(&self, evaluation: &Evaluation) -> Matrix3<f32> {
        let mut information = evaluation.slope.map_or_else(Matrix3::zeros, |s| s.information);
        let prior = self.prior.information();
        for axis in 0..3 {
            match prior[axis] {
                Some(known) => information[(axis, axis)] += known,
                None => {
                    for other in 0..3 {
                        information[(axis, other)] = 0.0;
                        information[(other, axis)] = 0.0;
                    }
                    information[(axis, axis)] = 1.0;
                }
            }
        }
        let mut covariance = match information.cholesky() {
            Some(root) => root.inverse(),
            None => Matrix3::from_diagonal(&nalgebra::Vector3::from(prior.map(|p| p.map_or(0.0, |i| 1.0 / i)))),
        };
        let floors = [FLOOR_POSITION_M, FLOOR_POSITION_M, FLOOR_YAW_RAD];
        for axis in 0..3 {
            covariance[(axis, axis)] =
                if prior[axis].is_some() { covariance[(axis, axis)] + floors[axis] * floors[axis] } else { 0.0 };
        }
        covariance
    }
}

/// Removes from a list in order of error every end that is next to a better one.
fn merge<const N: usize>(ends: &mut Vec<Found, N>) {
    let mut kept = 0;
    for at in 0..ends.len() {
        let Some(end) = ends.get(at).copied() else { break };
        let is_known = ends.iter().take(kept).any(|better| is_same(&better.pose, &end.pose));
        if end.evaluation.is_finite() && !is_known {
            if let Some(slot) = ends.get_mut(kept) {
                *slot = end;
            }
            kept += 1;
        }
    }
    ends.truncate(kept);
}

fn is_same(a: &PlanarPose, b: &PlanarPose) -> bool {
    libm::fabsf(a.x_m - b.x_m) < SAME_POSITION_M
        && libm::fabsf(a.y_m - b.y_m) < SAME_POSITION_M
        && libm::fabsf(a.phi_rad - b.phi_rad) < SAME_YAW_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::{Readiness, Tolerance};
    use crate::touch::{candidate, rehearse::rehearse};
    use tactus_common::pose::Interval;
    use tactus_common::shape::ObjectShape;

    const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;
    const GUESS: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.0 };

    fn prior(interval: Interval) -> Prior {
        Prior { guess: GUESS, interval, shape: SHAPE }
    }

    fn exact() -> UpdateConfig {
        let geometric = GeometricConfig { contact_depth_m: 0.0, ..GeometricConfig::default() };
        UpdateConfig { geometric, ..UpdateConfig::default() }
    }

    fn touched(ids: &[u8], truth: &PlanarPose) -> EvidenceStore {
        let mut store = EvidenceStore::new(SHAPE.top_height_m());
        for id in ids {
            rehearse(&mut store, &candidate(*id, &SHAPE).expect("listed"), &GUESS, truth, &SHAPE);
        }
        store
    }

    fn run(prior: &Prior, store: &EvidenceStore, slice: Work) -> (Belief, UpdateStats) {
        let mut update = Update::new(prior, &Belief::from_prior(prior), &exact());
        for _ in 0..200_000 {
            if update.step(&mut slice.clone(), store) == Progress::Done {
                return (update.belief().clone(), update.stats());
            }
        }
        panic!("no end");
    }

    #[test]
    fn three_touches_without_noise_give_the_pose() {
        let p = prior(Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 });
        for truth in [PlanarPose::new(0.22, -0.08, 0.15), PlanarPose::new(0.19, -0.12, -0.2), GUESS] {
            let (belief, stats) = run(&p, &touched(&[0, 6, 3], &truth), Work::unlimited());
            let pose = belief.pose();
            let off = [pose.x_m - truth.x_m, pose.y_m - truth.y_m, pose.phi_rad - truth.phi_rad];
            assert!(off[0].abs() < 3e-4 && off[1].abs() < 3e-4 && off[2].abs() < 3e-3, "{off:?} {stats:?}");
            assert_eq!(belief.readiness(&Tolerance::default()), Readiness::Ready, "{stats:?}");
            assert!(stats.evaluations < 400, "{stats:?}");
        }
    }

    #[test]
    fn one_touch_across_leaves_the_position_along_the_box_open() {
        let p = prior(Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 });
        let (belief, _) = run(&p, &touched(&[0], &GUESS), Work::unlimited());
        let sigma_x_m = libm::sqrtf(belief.covariance()[(0, 0)]);
        assert!(sigma_x_m > 0.015, "{sigma_x_m}");
        assert_ne!(belief.readiness(&Tolerance::default()), Readiness::Ready);
    }

    #[test]
    fn slicing_changes_nothing() {
        let p = prior(Interval { x_m: 0.1, y_m: 0.1, phi_rad: 0.78 });
        let store = touched(&[0, 7], &PlanarPose::new(0.22, -0.08, 0.15));
        let (whole, whole_stats) = run(&p, &store, Work::unlimited());
        let (sliced, sliced_stats) = run(&p, &store, Work::units(1));
        assert_eq!(whole_stats, sliced_stats);
        assert_eq!(whole.pose(), sliced.pose());
        assert_eq!(whole.covariance(), sliced.covariance());
    }

    #[test]
    fn components_known_exactly_stay_and_one_unknown_needs_two_contacts() {
        let p = prior(Interval { x_m: 0.0, y_m: 0.05, phi_rad: 0.0 });
        let truth = PlanarPose { y_m: -0.12, ..GUESS };
        let (belief, _) = run(&p, &touched(&[0], &truth), Work::unlimited());
        assert_eq!((belief.pose().x_m, belief.pose().phi_rad), (GUESS.x_m, GUESS.phi_rad));
        assert!((belief.pose().y_m - truth.y_m).abs() < 2e-4);
        assert_eq!(belief.covariance()[(0, 0)], 0.0);
        assert_eq!(belief.readiness(&Tolerance::default()), Readiness::Ready);
    }

    #[test]
    fn without_evidence_nothing_is_learnt() {
        let p = prior(Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 });
        let (belief, _) = run(&p, &EvidenceStore::new(0.2), Work::unlimited());
        assert_eq!(belief.readiness(&Tolerance::default()), Readiness::NoContact);
        assert!(libm::sqrtf(belief.covariance()[(0, 0)]) > 0.02);
    }

    #[test]
    fn one_false_contact_among_many_is_outvoted_or_named() {
        let p = prior(Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 });
        let truth = PlanarPose::new(0.21, -0.09, 0.1);
        let mut store = touched(&[0, 6, 3], &truth);
        // F1 is said to touch while it is open, 40 mm from the box.
        let plan = candidate(0, &SHAPE).expect("listed");
        let open = tactus_common::robot::hand::HandAngles::engaged(plan.preopen_rad, plan.spread_rad);
        let hand = plan.world_from_hand(&GUESS, &SHAPE);
        let kind = crate::evidence::ContactKind::Closing;
        store.add_contact(&hand, &open, crate::evidence::Toucher::Finger(0), kind).expect("room");
        let (belief, _) = run(&p, &store, Work::unlimited());
        let (dx, dy) = (belief.pose().x_m - truth.x_m, belief.pose().y_m - truth.y_m);
        assert!(dx.abs() < 1e-3 && dy.abs() < 1e-3, "{dx} {dy}");
        assert_eq!(belief.residuals().outliers, 1);
    }

    #[test]
    fn an_object_that_was_moved_far_is_noticed() {
        let p = prior(Interval { x_m: 0.05, y_m: 0.05, phi_rad: 0.35 });
        let mut store = touched(&[0, 6], &GUESS);
        let moved = PlanarPose::new(0.215, -0.085, 0.1);
        for id in [0, 6] {
            rehearse(&mut store, &candidate(id, &SHAPE).expect("listed"), &GUESS, &moved, &SHAPE);
        }
        let (belief, _) = run(&p, &store, Work::unlimited());
        assert_ne!(belief.readiness(&Tolerance::default()), Readiness::Ready);
    }
}
