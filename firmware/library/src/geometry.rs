//! Poses, shapes and beliefs as C sees them.

use crate::handle::Plain;
use crate::result::TactusResult;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::shape::ObjectShape;
use tactus_controller::belief::{Belief, Mode, Readiness, Tolerance};

/// How far the length of a rotation's quaternion may be from one.
const UNIT_SLACK: f32 = 1e-3;
/// Nearer to one than this is rounding: such a rotation is taken as it is, so that what Rust gave comes back to the bit.
const ROUNDING: f32 = 5e-7;

/// Pose of an object that stands upright on the table, in the world frame: z up, origin on the table top's centre.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusPose {
    /// World x of the object's centroid, metres.
    pub x_m: f32,
    /// World y of the object's centroid, metres.
    pub y_m: f32,
    /// Rotation about the world's z axis, radians, positive anticlockwise seen from above.
    pub phi_rad: f32,
}

// SAFETY: three numbers.
unsafe impl Plain for TactusPose {}

impl TactusPose {
    pub(crate) fn to_rust(self) -> PlanarPose {
        PlanarPose::new(self.x_m, self.y_m, self.phi_rad)
    }
}

impl From<PlanarPose> for TactusPose {
    fn from(p: PlanarPose) -> Self {
        Self { x_m: p.x_m, y_m: p.y_m, phi_rad: p.phi_rad }
    }
}

/// How far a guess may be off: the true pose lies within guess +- these. A component with 0 is known exactly.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TactusInterval {
    /// Half width in x, metres, 0 or more.
    pub x_m: f32,
    /// Half width in y, metres, 0 or more.
    pub y_m: f32,
    /// Half width in phi, radians, 0 or more.
    pub phi_rad: f32,
}

impl TactusInterval {
    pub(crate) fn to_rust(self) -> Interval {
        Interval { x_m: self.x_m, y_m: self.y_m, phi_rad: self.phi_rad }
    }
}

/// Kinds of object.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusShapeKind {
    /// A rectangular box that stands on its lower face.
    Cuboid = 0,
}

/// What the object is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusShape {
    /// A `TactusShapeKind`.
    pub kind: u8,
    /// Half the edge lengths along the object's x, y, z, metres, each above 0.
    pub half_extents_m: [f32; 3],
}

impl TactusShape {
    pub(crate) fn to_rust(self) -> Result<ObjectShape, TactusResult> {
        let shape = ObjectShape::Cuboid { half_extents_m: self.half_extents_m };
        let known = self.kind == TactusShapeKind::Cuboid as u8;
        if known && shape.is_valid() { Ok(shape) } else { Err(TactusResult::BadValue) }
    }
}

/// A place and an orientation in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusTransform {
    /// Origin, metres.
    pub position_m: [f32; 3],
    /// Rotation as a unit quaternion, scalar last: i, j, k, w.
    pub rotation_ijkw: [f32; 4],
}

impl TactusTransform {
    pub(crate) fn to_rust(self) -> Result<Isometry3<f32>, TactusResult> {
        let [x, y, z] = self.position_m;
        let [i, j, k, w] = self.rotation_ijkw;
        let quaternion = Quaternion::new(w, i, j, k);
        // Also false for what is no number.
        let off = (quaternion.norm() - 1.0).abs();
        let is_sound = off <= UNIT_SLACK && self.position_m.iter().all(|p| p.is_finite());
        let rotation = match off <= ROUNDING {
            true => UnitQuaternion::new_unchecked(quaternion),
            false => UnitQuaternion::new_normalize(quaternion),
        };
        is_sound.then(|| Isometry3::from_parts(Translation3::new(x, y, z), rotation)).ok_or(TactusResult::BadValue)
    }
}

impl From<&Isometry3<f32>> for TactusTransform {
    fn from(pose: &Isometry3<f32>) -> Self {
        Self { position_m: pose.translation.vector.into(), rotation_ijkw: pose.rotation.coords.into() }
    }
}

/// Whether a belief is good enough to grasp by (3 mm and 1.5 degrees, 99 %), and if not, why.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TactusReadiness {
    /// Narrow enough, explains the evidence, and checked by one contact more than there are unknowns.
    Ready = 0,
    /// Nothing has been touched yet.
    NoContact = 1,
    /// No pose explains all contacts and free links: something moved, or a reading was false.
    Inconsistent = 2,
    /// As many unknowns as contacts: anything can be explained, so nothing is checked yet.
    Unchecked = 3,
    /// Several poses far apart explain the evidence.
    Ambiguous = 4,
    /// One pose, but not exact enough.
    TooWide = 5,
}

impl From<Readiness> for TactusReadiness {
    fn from(readiness: Readiness) -> Self {
        match readiness {
            Readiness::Ready => Self::Ready,
            Readiness::NoContact => Self::NoContact,
            Readiness::Inconsistent => Self::Inconsistent,
            Readiness::Unchecked => Self::Unchecked,
            Readiness::Ambiguous => Self::Ambiguous,
            Readiness::TooWide => Self::TooWide,
        }
    }
}

/// Where the object is believed to stand.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusBelief {
    /// The believed pose: the mean over all poses that explain the evidence.
    pub pose: TactusPose,
    /// Covariance over x (m), y (m), phi (rad), symmetric.
    pub covariance: [[f32; 3]; 3],
    /// Half width that holds 99 % of the belief in the horizontal direction of the largest spread, metres.
    pub half_width_m: f32,
    /// Half width in yaw that holds 99 % of the belief, radians.
    pub half_width_rad: f32,
    /// Is it good enough to grasp by?
    pub readiness: TactusReadiness,
    /// Distinct poses that explain the evidence.
    pub modes: u8,
    /// Contacts that were fitted.
    pub contacts: u16,
    /// Contacts among them more than three standard deviations off at the best pose.
    pub outliers: u16,
    /// Links known to be free that would be deep inside the object at the best pose.
    pub collisions: u16,
}

impl From<&Belief> for TactusBelief {
    fn from(belief: &Belief) -> Self {
        let (half_width_m, half_width_rad) = belief.half_widths_99();
        let residuals = belief.residuals();
        Self {
            pose: belief.pose().into(),
            // Symmetric, so columns are rows.
            covariance: belief.covariance().into(),
            half_width_m,
            half_width_rad,
            readiness: belief.readiness(&Tolerance::default()).into(),
            modes: belief.modes().len() as u8,
            contacts: residuals.contacts,
            outliers: residuals.outliers,
            collisions: residuals.collisions,
        }
    }
}

/// One pose that explains the evidence.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TactusMode {
    /// The pose.
    pub pose: TactusPose,
    /// Its own covariance over x (m), y (m), phi (rad), symmetric.
    pub covariance: [[f32; 3]; 3],
    /// Share of the belief, 0..1.
    pub weight: f32,
    /// The error there, in chi-squared units.
    pub error: f32,
}

impl From<&Mode> for TactusMode {
    fn from(mode: &Mode) -> Self {
        Self { pose: mode.pose.into(), covariance: mode.covariance.into(), weight: mode.weight, error: mode.error }
    }
}
