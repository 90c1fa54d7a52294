//! The robot's numbers, generated at build time from `common/models/` (see `common/build.rs`).

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Limits of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimit {
    /// Smallest angle, radians.
    pub lower_rad: f32,
    /// Largest angle, radians.
    pub upper_rad: f32,
    /// Largest speed, rad/s.
    pub velocity_rad_s: f32,
    /// Largest torque at the joint, newton-metres.
    pub torque_nm: f32,
}

impl JointLimit {
    /// `true` if `q_rad` lies within the limits; NaN does not.
    pub fn contains(&self, q_rad: f32) -> bool {
        q_rad >= self.lower_rad && q_rad <= self.upper_rad
    }

    /// Distance from `q_rad` to the nearer limit, radians; negative outside.
    pub fn margin_rad(&self, q_rad: f32) -> f32 {
        (q_rad - self.lower_rad).min(self.upper_rad - q_rad)
    }
}

/// Where a link's frame lies at joint angle zero in the frame of the link before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointOrigin {
    /// Origin, metres.
    pub xyz_m: [f32; 3],
    /// Orientation, unit quaternion, scalar last.
    pub quaternion_ijkw: [f32; 4],
}

impl JointOrigin {
    /// Parent-from-child transform at joint angle zero.
    pub fn isometry(&self) -> Isometry3<f32> {
        let [x, y, z] = self.xyz_m;
        let [i, j, k, w] = self.quaternion_ijkw;
        Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)))
    }
}

/// Mass properties of one link, in the link's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass, kilograms.
    pub mass_kg: f32,
    /// Centre of mass, metres.
    pub com_m: [f32; 3],
    /// Inertia about the centre of mass: xx, xy, xz, yy, yz, zz (tensor elements), kg m^2.
    pub inertia_kg_m2: [f32; 6],
}

impl Inertial {
    /// Centre of mass as a vector, metres.
    pub fn com(&self) -> Vector3<f32> {
        Vector3::from(self.com_m)
    }

    /// Inertia about the centre of mass as a matrix, kg m^2.
    pub fn inertia(&self) -> Matrix3<f32> {
        let [xx, xy, xz, yy, yz, zz] = self.inertia_kg_m2;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }
}

/// One cell of a tactile pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taxel {
    /// Centre in the pad's frame (tip link, or hand), metres; lies on the link's collision shape.
    pub centre_m: [f32; 3],
    /// Outward normal, unit length.
    pub normal: [f32; 3],
    /// Area, square metres.
    pub area_m2: f32,
}

#[allow(clippy::approx_constant, reason = "these are the description's own roundings")]
mod generated {
    use super::{Inertial, JointLimit, JointOrigin, Taxel};
    use crate::shape::Prism;
    include!(concat!(env!("OUT_DIR"), "/robot_tables.rs"));
}

pub use generated::*;
