//! The list of object shapes that the estimator knows.

use super::{Hull, Prism, Separation, capsule, cuboid, cylinder, hull, sphere};
use core::f32::consts::{FRAC_PI_2, PI};
use nalgebra::{Isometry3, Point3, Vector3};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Shape of an object that stands on the table; its frame is at the centroid, z up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap; a shape is kept in few places and passed by reference"
)]
pub enum ObjectShape {
    /// A rectangular box.
    Cuboid {
        /// Half the edge lengths along the object's x, y, z, metres, all positive.
        half_extents_m: [f32; 3],
    },
    /// A cylinder that stands upright.
    Cylinder {
        /// Radius, metres.
        radius_m: f32,
        /// Half the height, metres.
        half_height_m: f32,
    },
    /// A sphere.
    Sphere {
        /// Radius, metres.
        radius_m: f32,
    },
    /// A cylinder with a half sphere at either end that lies along the object's x axis.
    Capsule {
        /// Radius, metres.
        radius_m: f32,
        /// Half the length between the centres of the half spheres, metres.
        half_length_m: f32,
    },
    /// A convex polyhedron that stands on its lowest corners.
    Convex(Hull),
}

impl Default for ObjectShape {
    /// The box of the published experiment.
    fn default() -> Self {
        Self::THESIS_BOX
    }
}

impl ObjectShape {
    /// The box of the published experiment: 0.2 m wide (x), 0.1 m deep (y), 0.2 m high (z).
    pub const THESIS_BOX: Self = Self::Cuboid { half_extents_m: [0.1, 0.05, 0.1] };

    /// Height of the object's frame above the table while the object stands, metres.
    pub fn rest_height_m(&self) -> f32 {
        match self {
            Self::Cuboid { half_extents_m } => half_extents_m[2],
            Self::Cylinder { half_height_m, .. } => *half_height_m,
            Self::Sphere { radius_m } | Self::Capsule { radius_m, .. } => *radius_m,
            Self::Convex(hull) => -hull.z_m()[0],
        }
    }

    /// Height of the object's highest point above the table while it stands, metres.
    pub fn top_height_m(&self) -> f32 {
        match self {
            Self::Cuboid { half_extents_m } => 2.0 * half_extents_m[2],
            Self::Cylinder { half_height_m, .. } => 2.0 * half_height_m,
            Self::Sphere { radius_m } | Self::Capsule { radius_m, .. } => 2.0 * radius_m,
            Self::Convex(hull) => hull.z_m()[1] - hull.z_m()[0],
        }
    }

    /// Half the extents of the smallest box about the object's origin, along its own x, y, z, that holds it, metres.
    pub fn half_extents_m(&self) -> [f32; 3] {
        match self {
            Self::Cuboid { half_extents_m } => *half_extents_m,
            Self::Cylinder { radius_m, half_height_m } => [*radius_m, *radius_m, *half_height_m],
            Self::Sphere { radius_m } => [*radius_m; 3],
            Self::Capsule { radius_m, half_length_m } => [half_length_m + radius_m, *radius_m, *radius_m],
            Self::Convex(hull) => hull.half_extents_m(),
        }
    }

    /// Smallest turn about the vertical that leaves the shape as it is, radians: pi for a box, pi/2 for a square one, a
    /// whole turn for a hull that no smaller one leaves alike; 0 if every turn does.
    pub fn yaw_symmetry_rad(&self) -> f32 {
        match self {
            Self::Cuboid { half_extents_m: [x, y, _] } if x == y => FRAC_PI_2,
            Self::Cuboid { .. } | Self::Capsule { .. } => PI,
            Self::Cylinder { .. } | Self::Sphere { .. } => 0.0,
            Self::Convex(hull) => hull.yaw_symmetry_rad(),
        }
    }

    /// `true` if every dimension is a positive finite number, and a hull is one.
    pub fn is_valid(&self) -> bool {
        let positive = |lengths: &[f32]| lengths.iter().all(|h| h.is_finite() && *h > 0.0);
        match self {
            Self::Cuboid { half_extents_m } => positive(half_extents_m),
            Self::Cylinder { radius_m, half_height_m } => positive(&[*radius_m, *half_height_m]),
            Self::Sphere { radius_m } => positive(&[*radius_m]),
            Self::Capsule { radius_m, half_length_m } => positive(&[*radius_m, *half_length_m]),
            Self::Convex(hull) => hull.is_valid(),
        }
    }

    /// Separation of a point (object frame, metres) along the axis that separates it most, metres: never more than
    /// its distance, negative inside.
    pub fn point_separation_m(&self, p: &Vector3<f32>) -> f32 {
        match self {
            Self::Cuboid { half_extents_m } => cuboid::point_separation_m(half_extents_m, p),
            Self::Cylinder { radius_m, half_height_m } => cylinder::point_separation_m(*radius_m, *half_height_m, p),
            Self::Sphere { radius_m } => sphere::point_separation_m(*radius_m, p),
            Self::Capsule { radius_m, half_length_m } => capsule::point_separation_m(*radius_m, *half_length_m, p),
            Self::Convex(hull) => hull.point_separation_m(p),
        }
    }

    /// What a separation without a limit costs in the mean over poses of all links near the object, in hundreds of instructions
    /// of a Cortex-M4F, as measured; for hulls a line somewhat above what prisms of 3 to 12 sides and a tetrahedron took. The
    /// worst are up to twice as dear, those with a limit mostly cheaper.
    pub const fn separation_cost(&self) -> u32 {
        match self {
            Self::Cuboid { .. } => 50,
            Self::Cylinder { .. } => 130,
            Self::Sphere { .. } => 15,
            Self::Capsule { .. } => 80,
            Self::Convex(hull) => 30 + 7 * hull.edge_count() as u32 / 2,
        }
    }

    /// A lower bound of the separation (metres) from the link's bounding sphere alone.
    pub fn separation_lower_bound_m(&self, object_from_link: &Isometry3<f32>, prism: &Prism) -> f32 {
        let (centre, radius_m) = prism.bounding_sphere();
        let p = object_from_link * Point3::from(centre);
        self.point_separation_m(&p.coords) - radius_m
    }

    /// Signed separation of a hand link from this object; see [`Separation`].
    pub fn separation(&self, object_from_link: &Isometry3<f32>, prism: &Prism) -> Option<Separation> {
        self.separation_below(object_from_link, prism, f32::INFINITY)
    }

    /// As [`Self::separation`], but `None` as soon as it is certain to be `limit_m` or more.
    ///
    /// Free-space terms and the nearest of several links need no more, and nearly all pairs end after a few axes.
    /// Also `None` if the pose is not finite. The shapes' own functions are never inlined: only the stack of the one that is
    /// called is taken then, and callers share their code.
    pub fn separation_below(
        &self,
        object_from_link: &Isometry3<f32>,
        prism: &Prism,
        limit_m: f32,
    ) -> Option<Separation> {
        let pose = object_from_link;
        match self {
            Self::Cuboid { half_extents_m } => cuboid::separation_below(half_extents_m, pose, prism, limit_m),
            Self::Cylinder { radius_m, half_height_m } => {
                cylinder::separation_below(*radius_m, *half_height_m, pose, prism, limit_m)
            }
            Self::Sphere { radius_m } => sphere::separation_below(*radius_m, pose, prism, limit_m),
            Self::Capsule { radius_m, half_length_m } => {
                capsule::separation_below(*radius_m, *half_length_m, pose, prism, limit_m)
            }
            Self::Convex(hull) => hull::separation_below(hull, pose, prism, limit_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_stands_on_its_lower_face_and_repeats_after_half_a_turn() {
        let shape = ObjectShape::THESIS_BOX;
        assert_eq!((shape.rest_height_m(), shape.top_height_m()), (0.1, 0.2));
        assert_eq!(shape.yaw_symmetry_rad(), PI);
        assert_eq!(ObjectShape::Cuboid { half_extents_m: [0.05, 0.05, 0.1] }.yaw_symmetry_rad(), FRAC_PI_2);
    }

    #[test]
    fn a_shape_with_a_side_that_is_no_length_is_refused() {
        assert!(ObjectShape::THESIS_BOX.is_valid());
        for bad in [0.0, -0.1, f32::NAN, f32::INFINITY] {
            assert!(!ObjectShape::Cuboid { half_extents_m: [0.1, bad, 0.1] }.is_valid());
        }
    }
}
