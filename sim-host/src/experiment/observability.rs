//! Observability: which poses the evidence cannot tell apart, and whether an error of the belief is the method's or
//! the evidence's.
//!
//! The ambiguity of a pose is the set of all poses whose error is within the noise of the least one. It is found by
//! profiles: one component is held at each value of its interval in turn, and the error is minimised over the others.
//! The widths along the components are exact then, also where the set falls into several parts.

use serde::{Deserialize, Serialize};
use tactus_common::pose::{Interval, PlanarPose};
use tactus_controller::belief::Prior;
use tactus_controller::error::{ErrorFunction, Geometric, GeometricConfig};
use tactus_controller::evidence::EvidenceStore;
use tactus_controller::optimise::{Ask, Bounds, LevenbergMarquardt, LevenbergMarquardtConfig, Optimiser, start};

/// Error above the least one, in chi-squared units, that noise explains with 95 %: for a pose of three components, and
/// for one component with the others chosen to suit it (a profile).
const POSE_MARGIN: f32 = 7.81;
const PROFILE_MARGIN: f32 = 3.84;
/// A pose nearer to the truth than this is located: 2 mm and 1 degree.
pub const LOCATED_M: f32 = 2e-3;
/// See [`LOCATED_M`].
pub const LOCATED_RAD: f32 = core::f32::consts::PI / 180.0;
/// Evidence whose ambiguity reaches farther from the best pose than this does not say where the object stands: what a
/// grasp forgives, 3 mm and 1.5 degrees.
const OBSERVABLE_M: f32 = 3e-3;
const OBSERVABLE_RAD: f32 = 1.5 * core::f32::consts::PI / 180.0;
/// Steps of the profiles.
const STEP_M: f32 = 5e-4;
const STEP_RAD: f32 = 5e-3;
/// Starts of the search at each step, besides the end of the step before.
const STARTS: u16 = 2;

/// What became of a belief.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Class {
    /// Within 2 mm and 1 degree of the truth.
    #[serde(rename = "located")]
    Located,
    /// Not so, but the true pose explains the evidence within noise as well: the evidence does not tell.
    #[serde(rename = "not observable")]
    NotObservable,
    /// Not so, and the evidence speaks against the true pose; or it tells the pose, and the search has missed it.
    #[serde(rename = "wrong")]
    Wrong,
}

impl Class {
    /// All, best first.
    pub const ALL: [Self; 3] = [Self::Located, Self::NotObservable, Self::Wrong];

    /// The name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Located => "located",
            Self::NotObservable => "not observable",
            Self::Wrong => "wrong",
        }
    }
}

/// The evidence of a set of touches.
pub struct Observed<'a> {
    error: Geometric<'a>,
    prior: &'a Prior,
}

/// How far the poses that explain the evidence within noise reach from the best one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ambiguity {
    /// In x, metres.
    pub x_m: f32,
    /// In y, metres.
    pub y_m: f32,
    /// In yaw, radians.
    pub phi_rad: f32,
}

impl Ambiguity {
    /// The evidence says where the object stands, as exactly as a grasp needs it.
    pub fn is_observable(&self) -> bool {
        self.x_m.max(self.y_m) <= OBSERVABLE_M && self.phi_rad <= OBSERVABLE_RAD
    }
}

impl<'a> Observed<'a> {
    /// Evidence about an object of which `prior` was known before.
    pub fn new(evidence: &'a EvidenceStore, prior: &'a Prior) -> Self {
        Self { error: Geometric::new(evidence, &prior.shape, &GeometricConfig::default()), prior }
    }

    /// What became of the belief that the object stands at `believed`, if it truly stands at `truth`; and the ambiguity.
    pub fn judge(&self, believed: &PlanarPose, truth: &PlanarPose) -> (Class, Ambiguity) {
        let best = self.minimise(&self.prior.bounds(), *believed);
        let ambiguity = self.ambiguity(&best);
        let off_m = believed.distance_m(truth);
        let off_rad = believed.turn_from_rad(truth, self.prior.shape.yaw_symmetry_rad()).abs();
        let is_explained = |pose: &PlanarPose| self.error.evaluate(pose).error <= best.1 + POSE_MARGIN;
        let class = if off_m <= LOCATED_M && off_rad <= LOCATED_RAD {
            Class::Located
        } else if !is_explained(truth) || (ambiguity.is_observable() && !is_explained(believed)) {
            Class::Wrong
        } else {
            Class::NotObservable
        };
        (class, ambiguity)
    }

    /// How far the poses that explain the evidence within noise reach from the best one, which is given with its error.
    fn ambiguity(&self, best: &(PlanarPose, f32)) -> Ambiguity {
        let half = self.prior.interval.to_array();
        let mut reach = [0.0_f32; 3];
        for axis in 0..3 {
            if half[axis] > 0.0 {
                reach[axis] = self.profile(axis, &best.0, best.1 + PROFILE_MARGIN);
            }
        }
        Ambiguity { x_m: reach[0], y_m: reach[1], phi_rad: reach[2] }
    }

    /// The greatest distance from `best` along a component at which the others can still be chosen so that the error is
    /// at most `limit`.
    fn profile(&self, axis: usize, best: &PlanarPose, limit: f32) -> f32 {
        let (centre, half) = (self.prior.guess.to_array(), self.prior.interval.to_array());
        let step = if axis == 2 { STEP_RAD } else { STEP_M };
        let from = best.to_array()[axis];
        let mut reach = 0.0_f32;
        for sign in [-1.0_f32, 1.0] {
            let mut last = *best;
            let mut off = 0.0_f32;
            loop {
                // Finely near the best pose, where the set has its edge; coarsely where other parts of it may lie.
                off += step.max(0.1 * off);
                let value = from + sign * off;
                if (value - centre[axis]).abs() > half[axis] {
                    break;
                }
                let (pose, error) = self.minimise_with(axis, value, last);
                last = pose;
                if error <= limit {
                    reach = (value - from).abs().max(reach);
                }
            }
        }
        reach
    }

    /// The least error with one component held.
    fn minimise_with(&self, axis: usize, value: f32, near: PlanarPose) -> (PlanarPose, f32) {
        let (mut centre, mut half) = (self.prior.guess.to_array(), self.prior.interval.to_array());
        (centre[axis], half[axis]) = (value, 0.0);
        let interval = Interval { x_m: half[0], y_m: half[1], phi_rad: half[2] };
        let bounds = Bounds::new(&PlanarPose::from_array(centre), &interval);
        self.minimise(&bounds, near)
    }

    fn minimise(&self, bounds: &Bounds, near: PlanarPose) -> (PlanarPose, f32) {
        let mut least = (near, f32::INFINITY);
        let starts = (0..STARTS).map(|index| bounds.at(start(index)));
        for from in std::iter::once(near).chain(starts) {
            let mut search = LevenbergMarquardt::new(&LevenbergMarquardtConfig::default(), bounds, &from);
            let found = loop {
                match search.ask() {
                    Ask::Evaluate(pose) => search.tell(&self.error.evaluate(&pose)),
                    Ask::Done(found, _) => break found,
                }
            };
            if found.evaluation.error < least.1 {
                least = (found.pose, found.evaluation.error);
            }
        }
        least
    }
}
