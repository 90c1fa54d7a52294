//! The solids that the planner keeps apart: the arm's primitives from the URDF, the hand's links as convex prisms.

use rapier3d::parry::math::{Pose, Vector};
use rapier3d::parry::shape::{Cuboid, SharedShape};
use tactus_common::robot::{HandLink, hand_prism};
use urdf_rs::Geometry;

/// A convex solid fixed to a link.
pub struct Body {
    /// The link: 0 is the base, 1 to 7 the arm's, 8 + [`HandLink::index`] the hand's.
    pub link: usize,
    /// Link-from-shape.
    local: Pose,
    /// The solid; a support map, as [`Body::new`] sees to.
    shape: SharedShape,
    /// Middle of the bounding sphere in the link's frame.
    centre_m: Vector,
    /// Radius of the bounding sphere, metres.
    pub radius_m: f32,
}

/// Why the robot's description cannot be used for planning.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// A link of the arm is missing.
    #[error("the URDF has no link `{0}`")]
    NoLink(String),
    /// A collision shape of the arm is not a box, cylinder or sphere.
    #[error("link `{0}`: collision shapes of the arm must be boxes, cylinders or spheres")]
    Shape(String),
    /// The corners of a hand link do not span a solid.
    #[error("hand link {0}: its prism is not a convex solid")]
    Prism(usize),
    /// An obstacle has no valid shape.
    #[error("obstacle {0}: its shape is not a solid")]
    Obstacle(usize),
}

/// Number of links of the arm with the base, hence the number of the hand's first link.
pub const HAND: usize = 8;

impl Body {
    fn new(link: usize, local: Pose, shape: SharedShape) -> Self {
        let sphere = shape.compute_local_bounding_sphere();
        Self { link, local, centre_m: local * sphere.center, radius_m: sphere.radius, shape }
    }

    /// Middle of the bounding sphere in the world, given the pose of the link.
    pub fn centre(&self, world_from_link: &Pose) -> Vector {
        *world_from_link * self.centre_m
    }

    /// Height of the lowest point above the table top, metres.
    pub fn lowest_m(&self, world_from_link: &Pose) -> f32 {
        match self.shape.as_support_map() {
            Some(shape) => shape.support_point_toward(&(*world_from_link * self.local), -Vector::Z).z,
            None => f32::NEG_INFINITY,
        }
    }

    /// Whether the solid overlaps a box that stands at `world_from_box`.
    pub fn meets_box(&self, world_from_link: &Pose, world_from_box: &Pose, half_m: Vector) -> bool {
        // The nearest point of the box to the sphere's middle settles most cases.
        let centre = world_from_box.inverse() * self.centre(world_from_link);
        let off = (centre.abs() - half_m).max(Vector::ZERO);
        if off.length_squared() > self.radius_m * self.radius_m {
            return false;
        }
        let cuboid = Cuboid::new(half_m);
        let box_from_shape = world_from_box.inv_mul(&(*world_from_link * self.local));
        // Shapes that the library cannot compare count as touching: a refused plan is better than a crash.
        rapier3d::parry::query::intersection_test(&Pose::IDENTITY, &cuboid, &box_from_shape, &*self.shape)
            .map_or(true, |t| t.intersecting)
    }

    /// Pose of the solid in the world, given that of the link.
    pub fn pose(&self, world_from_link: &Pose) -> Pose {
        *world_from_link * self.local
    }

    /// The solid.
    pub fn shape(&self) -> &SharedShape {
        &self.shape
    }

    /// Whether the solid overlaps a shape at `world_from_shape`.
    pub fn meets(&self, world_from_link: &Pose, shape: &SharedShape, world_from_shape: &Pose) -> bool {
        let own = self.pose(world_from_link);
        rapier3d::parry::query::intersection_test(world_from_shape, &**shape, &own, &*self.shape)
            .map_or(true, |t| t.intersecting)
    }

    /// Whether the solids overlap or are no farther apart than `margin_m`.
    pub fn near(&self, world_from_link: &Pose, other: &Body, world_from_other: &Pose, margin_m: f32) -> bool {
        let reach = self.radius_m + other.radius_m + margin_m;
        if (self.centre(world_from_link) - other.centre(world_from_other)).length_squared() > reach * reach {
            return false;
        }
        let (a, b) = (*world_from_link * self.local, *world_from_other * other.local);
        rapier3d::parry::query::distance(&a, &*self.shape, &b, &*other.shape).map_or(true, |d| d.distance <= margin_m)
    }
}

/// All solids of the robot: the arm's from the description, the hand's from the tables that were generated from it.
///
/// # Errors
/// [`ModelError`] if a link is missing or a shape is not one that can be used.
pub fn bodies(robot: &urdf_rs::Robot) -> Result<Vec<Body>, ModelError> {
    let mut bodies = Vec::new();
    for index in 0..HAND {
        let name = if index == 0 { "wam_base".to_owned() } else { format!("wam_link{index}") };
        let link = robot.links.iter().find(|link| link.name == name).ok_or_else(|| ModelError::NoLink(name.clone()))?;
        for collision in &link.collision {
            let (turn, shape) = shape_of(&collision.geometry).ok_or_else(|| ModelError::Shape(name.clone()))?;
            bodies.push(Body::new(index, pose_of(&collision.origin) * turn, shape));
        }
    }
    for link in HandLink::ALL {
        let prism = hand_prism(link);
        let corners: Vec<Vector> =
            prism.z_m.iter().flat_map(|z| prism.corners_m.iter().map(|c| Vector::new(c[0], c[1], *z))).collect();
        let shape = SharedShape::convex_hull(&corners).ok_or(ModelError::Prism(link.index()))?;
        bodies.push(Body::new(HAND + link.index(), Pose::IDENTITY, shape));
    }
    Ok(bodies)
}

/// The solid, and its turn into the library's convention (cylinders along y instead of z).
fn shape_of(geometry: &Geometry) -> Option<(Pose, SharedShape)> {
    match geometry {
        Geometry::Box { size } => {
            let [x, y, z] = size.0.map(|s| 0.5 * s as f32);
            Some((Pose::IDENTITY, SharedShape::cuboid(x, y, z)))
        }
        Geometry::Cylinder { radius, length } => {
            let turn = nalgebra::Isometry3::rotation(nalgebra::Vector3::x() * core::f32::consts::FRAC_PI_2);
            Some((turn.into(), SharedShape::cylinder(0.5 * *length as f32, *radius as f32)))
        }
        Geometry::Sphere { radius } => Some((Pose::IDENTITY, SharedShape::ball(*radius as f32))),
        Geometry::Capsule { .. } | Geometry::Mesh { .. } => None,
    }
}

/// A URDF origin: translation, then roll, pitch, yaw about fixed axes.
fn pose_of(origin: &urdf_rs::Pose) -> Pose {
    let [x, y, z] = origin.xyz.0.map(|v| v as f32);
    let [roll, pitch, yaw] = origin.rpy.0.map(|v| v as f32);
    nalgebra::Isometry3::from_parts(
        nalgebra::Translation3::new(x, y, z),
        nalgebra::UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
    .into()
}
