//! Belief: where the object may stand, as a few weighted poses with covariances.

use crate::error::geometric::Residuals;
use crate::optimise::{Bounds, start};
use crate::sort::insertion_sort;
use heapless::Vec;
use nalgebra::{Matrix2, Matrix3, Vector3};
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::shape::ObjectShape;

/// Modes that a belief holds.
pub const MODES_MAX: usize = 12;
/// Poses that stand for a belief where an expectation is taken.
pub const SAMPLES_MAX: usize = 8;
/// Standard deviations that hold 99 % of a normal distribution.
const SIGMAS_99: f32 = 2.576;

/// What is known before the first touch: the pose lies in `guess +- interval`, all equally likely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Middle of the region.
    pub guess: PlanarPose,
    /// Half widths; a component with 0 is known exactly.
    pub interval: Interval,
    /// The object's shape.
    pub shape: ObjectShape,
}

impl Prior {
    /// What a guess and an interval say about a shape: yaws that look alike are one. Of a shape that every turn leaves alike
    /// the yaw is known, of the others at most half its symmetry to either side is to be searched.
    pub fn new(guess: &PlanarPose, interval: &Interval, shape: &ObjectShape) -> Self {
        let phi_rad = interval.phi_rad.min(0.5 * shape.yaw_symmetry_rad());
        Self { guess: *guess, interval: Interval { phi_rad, ..*interval }, shape: *shape }
    }

    /// The region as bounds of a search.
    pub fn bounds(&self) -> Bounds {
        Bounds::new(&self.guess, &self.interval)
    }

    /// Information (inverse covariance) of a uniform distribution over a half width w: 3 / w^2 per component;
    /// `None` for one that is known exactly.
    pub fn information(&self) -> [Option<f32>; 3] {
        self.interval.to_array().map(|w| (libm::fabsf(w) > 0.0).then(|| 3.0 / (w * w)))
    }
}

/// One pose that explains the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// The pose.
    pub pose: PlanarPose,
    /// Its covariance over (x, y, phi), metres and radians.
    pub covariance: Matrix3<f32>,
    /// Share of the belief, 0..1; the shares add up to 1.
    pub weight: f32,
    /// The error there, in chi-squared units.
    pub error: f32,
}

/// How exact a belief must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Half width in any horizontal direction that must hold 99 % of the belief, metres.
    pub position_m: f32,
    /// Half width in yaw that must hold 99 % of the belief, radians.
    pub yaw_rad: f32,
    /// Chi-squared per degree of freedom (contacts less unknown components) up to which a fit is good.
    pub reduced_chi_squared: f32,
}

impl Default for Tolerance {
    /// What a two-sided grasp across the depth of the box forgives: 3 mm and 1.5 degrees; and a fit with twice the
    /// residuals' variance.
    fn default() -> Self {
        Self { position_m: 3e-3, yaw_rad: 1.5_f32.to_radians(), reduced_chi_squared: 2.0 }
    }
}

impl Tolerance {
    /// What a grasp of this shape forgives: a turn by which its farthest point moves as far as the box's does.
    pub fn of(shape: &ObjectShape) -> Self {
        let reach_m = |shape: &ObjectShape| {
            let [x_m, y_m, _] = shape.half_extents_m();
            libm::hypotf(x_m, y_m)
        };
        let of_box = Self::default();
        let ratio = (reach_m(&ObjectShape::THESIS_BOX) / reach_m(shape)).max(1.0);
        Self { yaw_rad: of_box.yaw_rad * ratio, ..of_box }
    }
}

/// Whether the object can be grasped at the believed pose, and if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// The belief is narrow enough and explains the evidence.
    Ready,
    /// Nothing has been touched yet.
    NoContact,
    /// No pose explains all contacts and free links within their accuracy: something moved, or a reading is false.
    Inconsistent,
    /// As many unknowns as contacts: anything can be explained, so nothing is checked yet. Or the contacts beyond that
    /// many do not fit well: not so badly that one must be false, but another touch has to tell.
    Unchecked,
    /// Several poses far apart explain the evidence.
    Ambiguous,
    /// One pose, but not exact enough.
    TooWide,
}

impl Default for Prior {
    /// Before anything was told: the box of the published experiment, known to stand in the middle of the table.
    fn default() -> Self {
        Self { guess: PlanarPose::default(), interval: Interval::default(), shape: ObjectShape::THESIS_BOX }
    }
}

/// The belief. About 900 bytes.
#[derive(Clone, Debug, Default)]
pub struct Belief {
    modes: Vec<Mode, MODES_MAX>,
    pose: PlanarPose,
    covariance: Matrix3<f32>,
    residuals: Residuals,
}

impl Belief {
    /// The belief before any touch: a few poses spread evenly over the prior's region.
    pub fn from_prior(prior: &Prior) -> Self {
        let bounds = prior.bounds();
        let mut modes = Vec::new();
        let mut spread = Matrix3::zeros();
        for (axis, information) in prior.information().iter().enumerate() {
            spread[(axis, axis)] = information.map_or(0.0, |i| 1.0 / i);
        }
        for index in 0..SAMPLES_MAX as u16 {
            let mode = Mode {
                pose: bounds.at(start(index)),
                // The samples share the region among them, so each keeps a part of its spread.
                covariance: spread * 0.25,
                weight: 1.0 / SAMPLES_MAX as f32,
                error: 0.0,
            };
            let _ = modes.push(mode);
        }
        let residuals = Residuals::default();
        Self { modes, pose: bounds.clamp(&prior.guess), covariance: spread, residuals }
    }

    /// A belief from modes with errors in chi-squared units; the weights are set here. `None` without modes.
    ///
    /// The pose is the mode of least error unless modes spread more than they are wide: then the mean.
    pub fn from_modes(mut modes: Vec<Mode, MODES_MAX>, residuals: Residuals) -> Option<Self> {
        insertion_sort(&mut modes, |a, b| a.error.total_cmp(&b.error));
        let best = *modes.first()?;
        let mut total = 0.0;
        for mode in &mut modes {
            mode.weight = libm::expf(-0.5 * (mode.error - best.error).clamp(0.0, 80.0));
            total += mode.weight;
        }
        let mut mean = Vector3::zeros();
        for mode in &mut modes {
            mode.weight /= total;
            mean += Vector3::from(mode.pose.to_array()) * mode.weight;
        }
        let mut covariance = Matrix3::zeros();
        for mode in &modes {
            let off = Vector3::from(mode.pose.to_array()) - mean;
            covariance += (mode.covariance + off * off.transpose()) * mode.weight;
        }
        Some(Self { modes, pose: PlanarPose::from_array(mean.into()), covariance, residuals })
    }

    /// The modes, the best first.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// The believed pose: the mean over the modes.
    pub fn pose(&self) -> PlanarPose {
        self.pose
    }

    /// Covariance over (x, y, phi) about [`Self::pose`], metres and radians, modes and their widths together.
    pub fn covariance(&self) -> Matrix3<f32> {
        self.covariance
    }

    /// How well the best mode explains the evidence.
    pub fn residuals(&self) -> Residuals {
        self.residuals
    }

    /// Half widths that hold 99 % of the belief if it is normal: in the horizontal direction of the largest spread
    /// (metres), and in yaw (radians).
    pub fn half_widths_99(&self) -> (f32, f32) {
        let xy: Matrix2<f32> = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let (mean, half_gap) = (0.5 * (xy[(0, 0)] + xy[(1, 1)]), 0.5 * (xy[(0, 0)] - xy[(1, 1)]));
        let largest = mean + libm::sqrtf(half_gap * half_gap + xy[(0, 1)] * xy[(0, 1)]);
        (SIGMAS_99 * libm::sqrtf(largest.max(0.0)), SIGMAS_99 * libm::sqrtf(self.covariance[(2, 2)].max(0.0)))
    }

    /// Can the object be grasped at [`Self::pose`]?
    pub fn readiness(&self, tolerance: &Tolerance) -> Readiness {
        if self.residuals.contacts == 0 {
            return Readiness::NoContact;
        }
        let (position_m, yaw_rad) = self.half_widths_99();
        let narrow = position_m <= tolerance.position_m && yaw_rad <= tolerance.yaw_rad;
        if !self.is_consistent() {
            Readiness::Inconsistent
        } else if narrow {
            if self.is_checked(tolerance) { Readiness::Ready } else { Readiness::Unchecked }
        } else if self.modes_are_apart(tolerance) {
            Readiness::Ambiguous
        } else {
            Readiness::TooWide
        }
    }

    /// `true` if the object can be grasped at [`Self::pose`].
    pub fn is_confident(&self, tolerance: &Tolerance) -> bool {
        self.readiness(tolerance) == Readiness::Ready
    }

    /// At most one contact in five may be off by more than three standard deviations, nothing known to be free may
    /// be deep inside, and the rest must fit as residuals of that many contacts do.
    pub fn is_consistent(&self) -> bool {
        let r = &self.residuals;
        let n = f32::from(r.contacts);
        // Mean n, variance 2 n: three standard deviations above the mean (no credit for the fitted components).
        let fits = r.chi_squared <= n + 3.0 * libm::sqrtf(2.0 * n);
        r.collisions == 0 && u32::from(r.outliers) * 5 <= u32::from(r.contacts) && fits
    }

    /// One contact of a closing finger more than there are unknown components, and a good fit.
    fn is_checked(&self, tolerance: &Tolerance) -> bool {
        usize::from(self.residuals.closings) > self.unknown()
            && self.reduced_chi_squared() <= tolerance.reduced_chi_squared
    }

    /// Components that are not known exactly.
    fn unknown(&self) -> usize {
        (0..3).filter(|axis| self.covariance[(*axis, *axis)] > 0.0).count()
    }

    /// Chi-squared of the contacts per degree of freedom; of as many contacts as unknown components, as if there were
    /// one degree.
    pub fn reduced_chi_squared(&self) -> f32 {
        let degrees = f32::from(self.residuals.contacts) - self.unknown() as f32;
        self.residuals.chi_squared / degrees.max(1.0)
    }

    fn modes_are_apart(&self, tolerance: &Tolerance) -> bool {
        self.modes.iter().any(|mode| {
            let (dx, dy) = (mode.pose.x_m - self.pose.x_m, mode.pose.y_m - self.pose.y_m);
            mode.weight > 0.01
                && (dx * dx + dy * dy > tolerance.position_m * tolerance.position_m
                    || libm::fabsf(mode.pose.phi_rad - self.pose.phi_rad) > tolerance.yaw_rad)
        })
    }

    /// Poses that stand for the belief, with weights that add up to 1: the modes, if they are many; else points at
    /// one and a half standard deviations about the few.
    pub fn samples(&self, bounds: &Bounds) -> Vec<(PlanarPose, f32), SAMPLES_MAX> {
        let mut samples = Vec::new();
        let leading: usize = self.modes.iter().filter(|m| m.weight > 0.02).count();
        if leading > 3 {
            for mode in self.modes.iter().take(SAMPLES_MAX) {
                let _ = samples.push((mode.pose, mode.weight));
            }
        } else {
            for mode in self.modes.iter().take(leading) {
                let _ = samples.push((mode.pose, mode.weight * 0.4));
            }
            // Two to six points remain: along the columns of the square root of the covariance.
            let root = square_root(&self.covariance);
            for column in (0..3).rev() {
                for sign in [1.0_f32, -1.0] {
                    let p = Vector3::from(self.pose.to_array()) + root.column(column) * (1.5 * sign);
                    let _ = samples.push((bounds.clamp(&PlanarPose::from_array(p.into())), 0.1));
                }
            }
        }
        let total: f32 = samples.iter().map(|s| s.1).sum();
        for sample in &mut samples {
            sample.1 /= total;
        }
        samples
    }
}

/// Lower triangular `L` with `L L' = covariance`; columns of components without variance are zero.
fn square_root(covariance: &Matrix3<f32>) -> Matrix3<f32> {
    let mut root = Matrix3::zeros();
    for row in 0..3 {
        for column in 0..=row {
            let mut sum = covariance[(row, column)];
            for k in 0..column {
                sum -= root[(row, k)] * root[(column, k)];
            }
            root[(row, column)] = if row == column {
                libm::sqrtf(sum.max(0.0))
            } else if root[(column, column)] > 1e-9 {
                sum / root[(column, column)]
            } else {
                0.0
            };
        }
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: Prior = Prior {
        guess: PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.1 },
        interval: Interval { x_m: 0.05, y_m: 0.0, phi_rad: 0.3 },
        shape: ObjectShape::THESIS_BOX,
    };

    fn mode(x_m: f32, error: f32) -> Mode {
        Mode { pose: PlanarPose::new(x_m, 0.0, 0.0), covariance: Matrix3::identity() * 1e-8, weight: 0.0, error }
    }

    fn touched(contacts: u16, chi_squared: f32) -> Residuals {
        Residuals { contacts, closings: contacts, chi_squared, ..Residuals::default() }
    }

    fn belief(modes: &[Mode], residuals: Residuals) -> Belief {
        Belief::from_modes(modes.iter().copied().collect(), residuals).expect("there are modes")
    }

    #[test]
    fn the_first_belief_is_as_wide_as_the_interval_and_never_ready() {
        let first = Belief::from_prior(&PRIOR);
        let sigma = libm::sqrtf(first.covariance()[(0, 0)]);
        assert!((sigma - 0.05 / libm::sqrtf(3.0)).abs() < 1e-6);
        assert_eq!(first.covariance()[(1, 1)], 0.0, "y is known exactly");
        assert_eq!(first.readiness(&Tolerance::default()), Readiness::NoContact);
        for (pose, _) in first.samples(&PRIOR.bounds()) {
            assert_eq!(pose.y_m, -0.1);
        }
    }

    #[test]
    fn a_smaller_object_forgives_a_larger_turn_and_the_box_what_it_did() {
        assert_eq!(Tolerance::of(&ObjectShape::THESIS_BOX), Tolerance::default());
        let small = Tolerance::of(&ObjectShape::Cuboid { half_extents_m: [0.03, 0.03, 0.15] });
        assert!((small.yaw_rad.to_degrees() - 3.95).abs() < 0.02 && small.position_m == 3e-3, "{small:?}");
        let large = Tolerance::of(&ObjectShape::Cuboid { half_extents_m: [0.3, 0.1, 0.1] });
        assert_eq!(large, Tolerance::default());
    }

    #[test]
    fn what_looks_alike_is_not_searched_twice_and_a_round_thing_has_no_yaw() {
        let wide = Interval { x_m: 0.05, y_m: 0.05, phi_rad: 3.0 };
        let width = |shape: &ObjectShape| Prior::new(&PlanarPose::default(), &wide, shape).interval.phi_rad;
        assert_eq!(width(&ObjectShape::THESIS_BOX), core::f32::consts::FRAC_PI_2);
        assert_eq!(width(&ObjectShape::Cuboid { half_extents_m: [0.1; 3] }), core::f32::consts::FRAC_PI_4);
        let round = ObjectShape::Cylinder { radius_m: 0.05, half_height_m: 0.1 };
        assert_eq!(width(&round), 0.0);
        let prior = Prior::new(&PlanarPose::default(), &wide, &round);
        assert_eq!((prior.interval.dof(), Belief::from_prior(&prior).unknown()), (2, 2));
    }

    #[test]
    fn two_poses_far_apart_are_ambiguous_and_one_is_ready() {
        let tolerance = Tolerance::default();
        let one = belief(&[mode(0.0, 1.0)], touched(4, 1.5));
        assert_eq!(one.readiness(&tolerance), Readiness::Ready);
        let two = belief(&[mode(0.0, 1.0), mode(0.02, 2.0)], touched(4, 1.5));
        assert_eq!(two.readiness(&tolerance), Readiness::Ambiguous);
        assert!(two.covariance()[(0, 0)] > 5e-5, "the spread of the modes counts");
    }

    #[test]
    fn three_contacts_do_not_check_three_unknowns() {
        let just_enough = belief(&[mode(0.0, 0.0)], touched(3, 0.0));
        assert_eq!(just_enough.readiness(&Tolerance::default()), Readiness::Unchecked);
    }

    #[test]
    fn a_poor_fit_asks_for_another_touch_unless_any_fit_will_do() {
        // Five contacts, three unknown components: two degrees of freedom.
        let [good, poor] = [3.9, 4.1].map(|chi_squared| belief(&[mode(0.0, 1.0)], touched(5, chi_squared)));
        assert!((poor.reduced_chi_squared() - 2.05).abs() < 1e-6);
        assert_eq!(good.readiness(&Tolerance::default()), Readiness::Ready);
        assert_eq!(poor.readiness(&Tolerance::default()), Readiness::Unchecked);
        let any = Tolerance { reduced_chi_squared: f32::INFINITY, ..Tolerance::default() };
        assert_eq!(poor.readiness(&any), Readiness::Ready);
    }

    #[test]
    fn contacts_that_no_pose_explains_are_not_trusted() {
        let odd = belief(&[mode(0.0, 30.0)], touched(4, 30.0));
        assert_eq!(odd.readiness(&Tolerance::default()), Readiness::Inconsistent);
        let inside = Residuals { collisions: 1, ..touched(4, 1.0) };
        assert_eq!(belief(&[mode(0.0, 1.0)], inside).readiness(&Tolerance::default()), Readiness::Inconsistent);
    }

    #[test]
    fn the_square_root_gives_the_covariance_back_even_if_a_component_is_fixed() {
        let c = Matrix3::new(4e-4, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 9e-4);
        let l = square_root(&c);
        assert!((l * l.transpose() - c).norm() < 1e-8);
    }
}
