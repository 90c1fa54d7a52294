//! The geometric error: touching links lie on the object's surface, free links outside it.
//!
//! Residual of a contact: the smallest signed separation over the links that it can be of, plus the depth by which an
//! onset is usually late. Residual of a free link: how much deeper than a tolerance it would be inside. Each in
//! standard deviations, through the robust loss `c^2 ln(1 + u^2/c^2)` (Cauchy), which bounds the pull of a late or
//! false contact. Smooth in the pose but for changes of the nearest feature, with analytic slope; compare Petrovskaya &
//! Khatib, *Global Localization of Objects via Touch* (2011).

use super::{ErrorFunction, Evaluation, Slope};
use crate::evidence::{Contact, ContactKind, EvidenceStore, FreeLink, PosedLink};
use crate::work::{SPHERE, Work};
use nalgebra::{Isometry3, Matrix3, Vector3};
use tactus_common::limits::HAND_LINKS;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::{HandLink, hand_prism};
use tactus_common::shape::{ObjectShape, Separation};

/// What residuals are worth. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometricConfig {
    /// Standard deviation of a contact's separation: late onset 0.3, box size 0.4, kinematics 0.3, shift 0.3 mm.
    pub contact_sigma_m: f32,
    /// Depth by which a link is inside the modelled surface when its contact is noticed, on average.
    pub contact_depth_m: f32,
    /// Standard deviation where the hand came down on something: the arm is softer than a finger.
    pub landing_sigma_m: f32,
    /// Standard deviation in a closed grasp.
    pub grasp_sigma_m: f32,
    /// Penetration of a free link that costs nothing.
    pub free_tolerance_m: f32,
    /// Standard deviation of a free link's penetration beyond the tolerance.
    pub free_sigma_m: f32,
    /// Standard deviation of the object's shift by one touch: older evidence counts less.
    pub shift_sigma_m: f32,
    /// Scale of the robust loss in standard deviations; larger = nearer to least squares.
    pub loss_scale: f32,
}

impl Default for GeometricConfig {
    fn default() -> Self {
        Self {
            contact_sigma_m: 0.6e-3,
            contact_depth_m: 0.3e-3,
            landing_sigma_m: 1.5e-3,
            grasp_sigma_m: 1.0e-3,
            free_tolerance_m: 1.0e-3,
            free_sigma_m: 0.8e-3,
            shift_sigma_m: 0.4e-3,
            loss_scale: 3.0,
        }
    }
}

/// Loss scale of exploring searches, in standard deviations: 15 mm at 0.5 mm.
const WIDE_LOSS_SCALE: f32 = 30.0;

impl GeometricConfig {
    /// The same with a loss that pulls from afar, for searches that explore.
    #[must_use]
    pub fn wide(self) -> Self {
        Self { loss_scale: WIDE_LOSS_SCALE, ..self }
    }
}

/// The geometric error over a store of evidence.
#[derive(Clone, Copy, Debug)]
pub struct Geometric<'a> {
    store: &'a EvidenceStore,
    shape: &'a ObjectShape,
    config: GeometricConfig,
    radius_m: [f32; HAND_LINKS],
}

/// How well a pose explains the contacts, loss aside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residuals {
    /// Contacts in the evidence.
    pub contacts: u16,
    /// Those among them of closing fingers: a hand that came down on the top says hardly where the object stands.
    pub closings: u16,
    /// Contacts farther from the surface than three standard deviations.
    pub outliers: u16,
    /// Free links deeper inside than the tolerance by more than three standard deviations.
    pub collisions: u16,
    /// Sum over the contacts of the squared residual in standard deviations, each at most 9.
    pub chi_squared: f32,
}

/// The hypothesised pose in the form that every term needs.
#[derive(Clone, Copy, Debug)]
struct Hypothesis {
    object_from_world: Isometry3<f32>,
    sin_cos_phi: (f32, f32),
}

impl<'a> Geometric<'a> {
    /// The error of poses of `shape` given the evidence in `store`.
    pub fn new(store: &'a EvidenceStore, shape: &'a ObjectShape, config: &GeometricConfig) -> Self {
        let radius_m = HandLink::ALL.map(|link| hand_prism(link).bounding_sphere().1);
        Self { store, shape, config: *config, radius_m }
    }

    /// How well `pose` explains the contacts, loss aside.
    pub fn residuals(&self, pose: &PlanarPose) -> Residuals {
        let mut under_way = self.begin_residuals(pose);
        // Without a limit there is always an end.
        self.proceed_residuals(&mut under_way, &mut Work::unlimited()).unwrap_or_default()
    }

    /// Begins to work out how well `pose` explains the contacts, loss aside.
    pub fn begin_residuals(&self, pose: &PlanarPose) -> ResidualsUnderWay {
        ResidualsUnderWay { walk: self.begin_walk(pose), found: Residuals::default() }
    }

    /// Goes on with residuals; `Some` at the end. The evidence must be the same in every slice.
    pub fn proceed_residuals(&self, under_way: &mut ResidualsUnderWay, work: &mut Work) -> Option<Residuals> {
        let found = &mut under_way.found;
        let is_over = self.walk(&mut under_way.walk, work, |term| {
            let u = term.found.map_or(f32::INFINITY, |_| term.residual_m / term.sigma_m);
            match term.of {
                Of::Contact(kind) => {
                    found.contacts += 1;
                    found.closings += u16::from(kind != ContactKind::Landing);
                    found.outliers += u16::from(libm::fabsf(u) > 3.0);
                    found.chi_squared += (u * u).min(9.0);
                }
                Of::Free => found.collisions += u16::from(u < -3.0),
            }
        });
        is_over.then_some(under_way.found)
    }

    /// Begins to evaluate the error at `pose`.
    pub fn begin(&self, pose: &PlanarPose) -> UnderWay {
        let (error, half_gradient, information) = (0.0, Vector3::zeros(), Matrix3::zeros());
        let loss_scale_sq = self.config.loss_scale * self.config.loss_scale;
        UnderWay { walk: self.begin_walk(pose), sum: Sum { error, half_gradient, information, loss_scale_sq } }
    }

    /// Goes on with an evaluation; `Some` at the end. The evidence must be the same in every slice.
    pub fn proceed(&self, under_way: &mut UnderWay, work: &mut Work) -> Option<Evaluation> {
        let (sum, sin_cos_phi) = (&mut under_way.sum, under_way.walk.at.sin_cos_phi);
        let is_over = self.walk(&mut under_way.walk, work, |term| match term.found {
            Some(found) => sum.add(term.residual_m, found.gradient_world(sin_cos_phi), term.sigma_m),
            // Only for a pose that is no number: the error says so.
            None => sum.error = f32::INFINITY,
        });
        let slope = Slope { half_gradient: under_way.sum.half_gradient, information: under_way.sum.information };
        is_over.then_some(Evaluation { error: under_way.sum.error, slope: Some(slope) })
    }

    fn begin_walk(&self, pose: &PlanarPose) -> Walk {
        Walk { at: self.hypothesis(pose), next: 0 }
    }

    /// Goes on through contacts and free links that are not where they should be; `true` at the end.
    fn walk(&self, walk: &mut Walk, work: &mut Work, mut each: impl FnMut(Term)) -> bool {
        let (contacts, free) = (self.store.contacts(), self.store.free());
        while walk.next < contacts.len() + free.len() {
            if !work.is_left_for(self.shape) {
                return false;
            }
            if let Some(contact) = contacts.get(walk.next) {
                let found = self.nearest(contact, &walk.at, work);
                let residual_m = found.map_or(f32::INFINITY, |s| s.distance_m + self.depth_m(contact));
                each(Term { of: Of::Contact(contact.kind), found, residual_m, sigma_m: self.contact_sigma_m(contact) });
            } else if let Some(free) = free.get(walk.next - contacts.len())
                && let Some(found) = self.intrusion(free, &walk.at, work)
            {
                let residual_m = found.distance_m + self.config.free_tolerance_m;
                each(Term { of: Of::Free, found: Some(found), residual_m, sigma_m: self.free_sigma_m(free) });
            }
            walk.next += 1;
        }
        true
    }

    fn hypothesis(&self, pose: &PlanarPose) -> Hypothesis {
        Hypothesis {
            object_from_world: pose.isometry(self.shape.rest_height_m()).inverse(),
            sin_cos_phi: libm::sincosf(pose.phi_rad),
        }
    }

    fn aged_sigma_m(&self, sigma_m: f32, touch: u8) -> f32 {
        let shift_m = self.config.shift_sigma_m;
        libm::sqrtf(sigma_m * sigma_m + f32::from(self.store.age(touch)) * shift_m * shift_m)
    }

    fn contact_sigma_m(&self, contact: &Contact) -> f32 {
        let sigma_m = match contact.kind {
            ContactKind::Closing => self.config.contact_sigma_m,
            ContactKind::Landing => self.config.landing_sigma_m,
            ContactKind::Grasp => self.config.grasp_sigma_m,
        };
        self.aged_sigma_m(sigma_m, contact.touch)
    }

    fn depth_m(&self, contact: &Contact) -> f32 {
        match contact.kind {
            ContactKind::Closing | ContactKind::Grasp => self.config.contact_depth_m,
            ContactKind::Landing => 0.0,
        }
    }

    fn free_sigma_m(&self, free: &FreeLink) -> f32 {
        self.aged_sigma_m(self.config.free_sigma_m, free.touch)
    }

    /// Separation of a link from the object, if less than `limit_m`; a sphere test first.
    fn separation(&self, posed: &PosedLink, at: &Hypothesis, limit_m: f32, work: &mut Work) -> Option<Separation> {
        work.spend(SPHERE);
        let centre = at.object_from_world * nalgebra::Point3::from(posed.centre_world_m);
        let bound_m = self.shape.point_separation_m(&centre.coords) - self.radius_m[posed.link.index()];
        if bound_m >= limit_m {
            return None;
        }
        work.spend(self.shape.separation_cost());
        self.shape.separation_below(&(at.object_from_world * posed.world_from_link), hand_prism(posed.link), limit_m)
    }

    /// The nearest of a contact's links.
    fn nearest(&self, contact: &Contact, at: &Hypothesis, work: &mut Work) -> Option<Separation> {
        let mut nearest: Option<Separation> = None;
        // Tips come last in the list and touch most often.
        for posed in contact.links.iter().rev() {
            let limit_m = nearest.as_ref().map_or(f32::INFINITY, |n| n.distance_m);
            if let Some(s) = self.separation(posed, at, limit_m, work) {
                nearest = Some(s);
            }
        }
        nearest
    }

    /// The separation of a free link, if it is inside by more than the tolerance.
    fn intrusion(&self, free: &FreeLink, at: &Hypothesis, work: &mut Work) -> Option<Separation> {
        self.separation(&free.posed, at, -self.config.free_tolerance_m, work)
    }
}

/// Sums up residuals under the robust loss.
#[derive(Clone, Copy, Debug)]
struct Sum {
    error: f32,
    half_gradient: Vector3<f32>,
    information: Matrix3<f32>,
    loss_scale_sq: f32,
}

impl Sum {
    fn add(&mut self, residual_m: f32, gradient: [f32; 3], sigma_m: f32) {
        let u = residual_m / sigma_m;
        let j = Vector3::from(gradient) / sigma_m;
        let ratio = u * u / self.loss_scale_sq;
        let weight = 1.0 / (1.0 + ratio);
        self.error += self.loss_scale_sq * libm::log1pf(ratio);
        self.half_gradient += j * (weight * u);
        for row in 0..3 {
            for column in 0..3 {
                self.information[(row, column)] += weight * j[row] * j[column];
            }
        }
    }
}

/// How far a walk through the evidence is.
#[derive(Clone, Copy, Debug)]
struct Walk {
    at: Hypothesis,
    /// Index of the next contact, or after the contacts of the next free link.
    next: usize,
}

/// What a term of the error belongs to.
enum Of {
    Contact(ContactKind),
    Free,
}

/// A term of the error.
struct Term {
    of: Of,
    /// The separation; `None` for a contact and a pose that is no number.
    found: Option<Separation>,
    residual_m: f32,
    sigma_m: f32,
}

/// An evaluation under way: for [`Geometric::proceed`].
#[derive(Clone, Copy, Debug)]
pub struct UnderWay {
    walk: Walk,
    sum: Sum,
}

/// Residuals under way: for [`Geometric::proceed_residuals`].
#[derive(Clone, Copy, Debug)]
pub struct ResidualsUnderWay {
    walk: Walk,
    found: Residuals,
}

impl ErrorFunction for Geometric<'_> {
    fn evaluate(&self, pose: &PlanarPose) -> Evaluation {
        let mut under_way = self.begin(pose);
        // Without a limit there is always an end.
        self.proceed(&mut under_way, &mut Work::unlimited()).unwrap_or(Evaluation { error: f32::INFINITY, slope: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touch::{candidate, rehearse::rehearse};

    const SHAPE: ObjectShape = ObjectShape::THESIS_BOX;
    const TRUTH: PlanarPose = PlanarPose { x_m: 0.21, y_m: -0.09, phi_rad: 0.2 };
    const BELIEVED: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.1 };

    fn store_of(ids: &[u8]) -> EvidenceStore {
        let mut store = EvidenceStore::new(SHAPE.top_height_m());
        for id in ids {
            rehearse(&mut store, &candidate(*id, &SHAPE).expect("listed"), &BELIEVED, &TRUTH, &SHAPE);
        }
        store
    }

    fn exact() -> GeometricConfig {
        GeometricConfig { contact_depth_m: 0.0, ..GeometricConfig::default() }
    }

    #[test]
    fn the_truth_explains_what_it_caused_and_other_poses_do_not() {
        let store = store_of(&[0, 6]);
        let error = Geometric::new(&store, &SHAPE, &exact());
        assert!(error.evaluate(&TRUTH).error < 0.5);
        for off in [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.08], [-0.01, 0.0, 0.0], [0.0, -0.03, -0.1]] {
            let pose = PlanarPose::new(TRUTH.x_m + off[0], TRUTH.y_m + off[1], TRUTH.phi_rad + off[2]);
            assert!(error.evaluate(&pose).error > 10.0, "{off:?}");
        }
        let residuals = error.residuals(&TRUTH);
        assert_eq!((residuals.contacts, residuals.closings, residuals.outliers, residuals.collisions), (6, 6, 0, 0));
    }

    #[test]
    fn the_slope_agrees_with_differences() {
        let store = store_of(&[1, 7, 10]);
        let config = GeometricConfig { loss_scale: 30.0, ..exact() };
        let error = Geometric::new(&store, &SHAPE, &config);
        let mut compared = 0;
        for index in 0..40_u16 {
            let unit = crate::optimise::start(index);
            let pose = [0.17 + 0.08 * unit[0], -0.13 + 0.08 * unit[1], -0.1 + 0.6 * unit[2]];
            let slope = error.evaluate(&PlanarPose::from_array(pose)).slope.expect("analytic").half_gradient * 2.0;
            for axis in 0..3 {
                let by = 2e-5;
                let at = |sign: f32| {
                    let mut p = pose;
                    p[axis] += sign * by;
                    error.evaluate(&PlanarPose::from_array(p))
                };
                let (low, high) = (at(-1.0), at(1.0));
                let slopes = [low, high].map(|e| e.slope.expect("analytic").half_gradient[axis] * 2.0);
                // Skip where a nearest feature changes within the step.
                if (slopes[0] - slopes[1]).abs() < 0.02 * slope.norm() {
                    let difference = (high.error - low.error) / (2.0 * by);
                    let scale = slope.norm() + 0.01 * low.error / by;
                    assert!((difference - slope[axis]).abs() < 0.03 * scale, "{difference} {}", slope[axis]);
                    compared += 1;
                }
            }
        }
        assert!(compared > 60, "{compared}");
    }

    #[test]
    fn a_pose_through_a_free_link_costs_even_without_any_contact() {
        let mut store = EvidenceStore::new(SHAPE.top_height_m());
        store.begin_touch();
        let plan = candidate(0, &SHAPE).expect("listed");
        let hand = plan.world_from_hand(&BELIEVED, &SHAPE);
        let open = tactus_common::robot::hand::HandAngles::engaged(plan.preopen_rad, plan.spread_rad);
        store.add_free(&hand, &open, [true; 3]).expect("room");
        let error = Geometric::new(&store, &SHAPE, &exact());
        assert_eq!(error.evaluate(&BELIEVED).error, 0.0);
        let across = PlanarPose { y_m: BELIEVED.y_m + 0.09, ..BELIEVED };
        assert!(error.evaluate(&across).error > 10.0);
        assert!(error.residuals(&across).collisions > 0);
    }

    #[test]
    fn evidence_counts_less_the_more_touches_came_after_it() {
        let mut store = store_of(&[0]);
        let information = |store: &EvidenceStore| {
            Geometric::new(store, &SHAPE, &exact()).evaluate(&TRUTH).slope.expect("analytic").information.trace()
        };
        let fresh = information(&store);
        store.begin_touch();
        store.begin_touch();
        let aged = information(&store);
        assert!(aged < 0.7 * fresh && aged > 0.0, "{fresh} {aged}");
    }

    #[test]
    fn a_pose_that_is_no_number_has_no_finite_error() {
        let store = store_of(&[0]);
        let error = Geometric::new(&store, &SHAPE, &exact());
        assert!(!error.evaluate(&PlanarPose::new(f32::NAN, 0.0, 0.0)).is_finite());
    }
}
