//! Shapes as the physics library has them.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rapier3d::parry::mass_properties::details::tetrahedron_unit_inertia_tensor_wrt_point;
use rapier3d::prelude::{ColliderBuilder, MassProperties, Pose, Rotation, SharedShape, Vector};
use tactus_common::shape::ObjectShape;

/// The solid of a body.
#[derive(Clone)]
pub struct Solid {
    /// Body-from-shape: the library's cylinders lie along y.
    pub in_body: Pose,
    /// The shape.
    pub shape: SharedShape,
    /// Height of the body's frame (its centroid) over what it stands on, metres.
    pub rest_height_m: f32,
    /// Half the extents of the bounding box about the body's frame, metres.
    pub half_extents_m: [f32; 3],
    /// Radius of what rolls, metres; `None` for what has edges.
    pub roll_radius_m: Option<f32>,
    /// Inertia of a hull of mass 1 kg about its centroid; the library knows that of the other shapes.
    hull_inertia_m2: Option<Matrix3<f32>>,
}

impl Solid {
    /// The solid of a shape; `None` if the shape is not valid.
    pub fn new(shape: &ObjectShape) -> Option<Self> {
        Self::resized(shape, &[0.0; 3])
    }

    /// The solid of a shape whose full dimensions along x, y and z are larger by `more_m`, metres. What is round stays
    /// round: a radius takes the change along x (of a capsule, which lies along x, that along y).
    pub fn resized(shape: &ObjectShape, more_m: &[f32; 3]) -> Option<Self> {
        let resized = grown(shape, more_m);
        if !resized.is_valid() {
            return None;
        }
        let upright = Pose::from_rotation(Rotation::from_rotation_arc(Vector::Y, Vector::Z));
        let mut rest_height_m = resized.rest_height_m();
        let mut half_extents_m = resized.half_extents_m();
        let mut hull_inertia_m2 = None;
        let (in_body, shape, roll_radius_m) = match &resized {
            ObjectShape::Cuboid { half_extents_m: [x, y, z] } => {
                (Pose::IDENTITY, SharedShape::cuboid(*x, *y, *z), None)
            }
            ObjectShape::Cylinder { radius_m, half_height_m } => {
                (upright, SharedShape::cylinder(*half_height_m, *radius_m), Some(*radius_m))
            }
            ObjectShape::Sphere { radius_m } => (Pose::IDENTITY, SharedShape::ball(*radius_m), Some(*radius_m)),
            ObjectShape::Capsule { radius_m, half_length_m } => {
                let end = Vector::X * *half_length_m;
                (Pose::IDENTITY, SharedShape::capsule(-end, end, *radius_m), Some(*radius_m))
            }
            ObjectShape::Convex(hull) => {
                let scale = scales(&hull.half_extents_m(), more_m);
                let corners: Vec<Vector> = hull
                    .corners_m()
                    .iter()
                    .map(|c| Vector::new(c[0] * scale[0], c[1] * scale[1], c[2] * scale[2]))
                    .collect();
                rest_height_m *= scale[2];
                let faces = hull.faces().map(|face| face.iter().map(|i| usize::from(*i)).collect());
                hull_inertia_m2 = Some(inertia_m2(&corners, faces));
                half_extents_m = core::array::from_fn(|axis| half_extents_m[axis] * scale[axis]);
                (Pose::IDENTITY, SharedShape::convex_hull(&corners)?, None)
            }
        };
        Some(Self { in_body, shape, rest_height_m, half_extents_m, roll_radius_m, hull_inertia_m2 })
    }

    /// A collider of this solid and mass, homogeneous.
    pub fn collider(&self, mass_kg: f32) -> ColliderBuilder {
        let collider = ColliderBuilder::new(self.shape.clone()).position(self.in_body);
        match &self.hull_inertia_m2 {
            None => collider.mass(mass_kg),
            Some(inertia_m2) => collider.mass_properties(mass_properties(mass_kg, &(inertia_m2 * mass_kg))),
        }
    }
}

/// Inertia of a homogeneous solid of 1 kg about the origin, its centroid: the sum over the tetrahedra between it and the
/// triangles of its faces.
fn inertia_m2(corners_m: &[Vector], faces: impl Iterator<Item = Vec<usize>>) -> Matrix3<f32> {
    let (mut volume_m3, mut moments) = (0.0, Matrix3::zeros());
    for face in faces {
        for (b, c) in face.iter().zip(face.iter().skip(1)).skip(1) {
            let [a, b, c] = [face[0], *b, *c].map(|i| corners_m[i]);
            let part_m3 = a.dot(b.cross(c)) / 6.0;
            let part = tetrahedron_unit_inertia_tensor_wrt_point(Vector::ZERO, Vector::ZERO, a, b, c);
            moments += Matrix3::from_column_slice(&part.to_cols_array()) * part_m3;
            volume_m3 += part_m3;
        }
    }
    moments / volume_m3
}

/// Mass properties by nalgebra's decomposition: parry's own finds wrong axes for a body that is alike about two of them.
fn mass_properties(mass_kg: f32, inertia_kg_m2: &Matrix3<f32>) -> MassProperties {
    let eigen = inertia_kg_m2.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let frame = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let [x, y, z, w] = frame.coords.into();
    let [a, b, c] = eigen.eigenvalues.into();
    let principal = Vector::new(a, b, c);
    MassProperties::with_principal_inertia_frame(Vector::ZERO, mass_kg, principal, Rotation::from_xyzw(x, y, z, w))
}

/// The shape with its dimensions changed; a hull as it is, for its corners are moved where they are used.
fn grown(shape: &ObjectShape, more_m: &[f32; 3]) -> ObjectShape {
    let half = more_m.map(|more| 0.5 * more);
    match shape {
        ObjectShape::Cuboid { half_extents_m } => {
            ObjectShape::Cuboid { half_extents_m: core::array::from_fn(|axis| half_extents_m[axis] + half[axis]) }
        }
        ObjectShape::Cylinder { radius_m, half_height_m } => {
            ObjectShape::Cylinder { radius_m: radius_m + half[0], half_height_m: half_height_m + half[2] }
        }
        ObjectShape::Sphere { radius_m } => ObjectShape::Sphere { radius_m: radius_m + half[0] },
        ObjectShape::Capsule { radius_m, half_length_m } => {
            ObjectShape::Capsule { radius_m: radius_m + half[1], half_length_m: half_length_m + half[0] }
        }
        ObjectShape::Convex(hull) => ObjectShape::Convex(*hull),
    }
}

/// Factors along each axis that make a body of these half extents larger by `more_m`.
fn scales(half_extents_m: &[f32; 3], more_m: &[f32; 3]) -> [f32; 3] {
    core::array::from_fn(|axis| 1.0 + 0.5 * more_m[axis] / half_extents_m[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_common::shape::Hull;

    /// The box of half edges 0.03, 0.04, 0.05 m as a hull.
    fn hull() -> ObjectShape {
        let corner = |i: usize| [0, 1, 2].map(|k| [0.03, 0.04, 0.05][k] * if i >> k & 1 == 1 { 1.0 } else { -1.0 });
        let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let faces: [&[u8]; 6] =
            [&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]];
        ObjectShape::Convex(Hull::new(&corners, faces).unwrap())
    }

    #[test]
    fn every_shape_fills_its_bounding_box_stands_on_the_table_and_grows_as_told() {
        let more_m = [0.002, -0.001, 0.003];
        for (shape, grows_m) in [
            (ObjectShape::Cuboid { half_extents_m: [0.03, 0.04, 0.05] }, more_m),
            (ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.1 }, [0.002, 0.002, 0.003]),
            (ObjectShape::Sphere { radius_m: 0.05 }, [0.002; 3]),
            (ObjectShape::Capsule { radius_m: 0.03, half_length_m: 0.05 }, [0.001, -0.001, -0.001]),
            (hull(), more_m),
        ] {
            for (solid, grown_m) in
                [(Solid::new(&shape).unwrap(), [0.0; 3]), (Solid::resized(&shape, &more_m).unwrap(), grows_m)]
            {
                let around = solid.shape.compute_aabb(&solid.in_body);
                let extents = around.half_extents();
                for axis in 0..3 {
                    let half_m = shape.half_extents_m()[axis] + 0.5 * grown_m[axis];
                    assert!((extents[axis] - half_m).abs() < 1e-6, "{shape:?} {axis}: {} {half_m}", extents[axis]);
                    assert!((solid.half_extents_m[axis] - half_m).abs() < 1e-6, "{shape:?}");
                }
                assert!((around.mins.z + solid.rest_height_m).abs() < 1e-6, "{shape:?}");
            }
        }
    }
}
