//! Shapes as Foxglove's scene primitives: boxes, cylinders, spheres as they are, a capsule as a cylinder with two spheres,
//! everything else as triangles.

use super::convert::{point, pose, vector};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, SceneEntity, SpherePrimitive, TriangleListPrimitive,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::{SharedShape, TypedShape};

/// Adds a shape, posed in the entity's frame, in one colour.
///
/// # Errors
/// It is none of the shapes that worlds are made of.
pub fn add(entity: &mut SceneEntity, at: &Isometry3<f32>, shape: &SharedShape, color: Color) -> anyhow::Result<()> {
    match shape.as_typed_shape() {
        TypedShape::Cuboid(cuboid) => entity.cubes.push(CubePrimitive {
            pose: Some(pose(at)),
            size: Some(vector((cuboid.half_extents * 2.0).to_array())),
            color: Some(color),
        }),
        TypedShape::Cylinder(c) => add_cylinder(entity, &upright(at), c.radius, c.half_height, color),
        TypedShape::Ball(ball) => add_sphere(entity, at, ball.radius, color),
        TypedShape::Capsule(capsule) => {
            let [a, b] = [capsule.segment.a, capsule.segment.b].map(|end| Vector3::from(end.to_array()));
            let along = UnitQuaternion::rotation_between(&Vector3::z(), &(b - a)).unwrap_or_default();
            let middle = at * Isometry3::from_parts(((a + b) / 2.0).into(), along);
            add_cylinder(entity, &middle, capsule.radius, (b - a).norm() / 2.0, color);
            for end in [a, b] {
                add_sphere(entity, &(at * nalgebra::Translation3::from(end)), capsule.radius, color);
            }
        }
        TypedShape::ConvexPolyhedron(hull) => {
            let (points, triangles) = hull.to_trimesh();
            add_triangles(entity, at, points.iter().map(|p| p.to_array()), &triangles, color);
        }
        other => anyhow::bail!("a recording cannot show a shape of the kind {:?}", other),
    }
    Ok(())
}

/// From rapier's cylinder, which stands along y, to one that stands along z.
fn upright(at: &Isometry3<f32>) -> Isometry3<f32> {
    at * UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::y()).unwrap_or_default()
}

fn add_cylinder(entity: &mut SceneEntity, at: &Isometry3<f32>, radius_m: f32, half_m: f32, color: Color) {
    entity.cylinders.push(CylinderPrimitive {
        pose: Some(pose(at)),
        size: Some(vector([2.0 * radius_m, 2.0 * radius_m, 2.0 * half_m])),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    });
}

fn add_sphere(entity: &mut SceneEntity, at: &Isometry3<f32>, radius_m: f32, color: Color) {
    entity.spheres.push(SpherePrimitive {
        pose: Some(pose(at)),
        size: Some(vector([2.0 * radius_m; 3])),
        color: Some(color),
    });
}

/// Triangles with corners of their own, so that a viewer's shading keeps their edges.
fn add_triangles(
    entity: &mut SceneEntity,
    at: &Isometry3<f32>,
    corners: impl Iterator<Item = [f32; 3]>,
    triangles: &[[u32; 3]],
    color: Color,
) {
    let corners: Vec<_> = corners.map(point).collect();
    let points = triangles.iter().flatten().filter_map(|i| corners.get(*i as usize).copied()).collect();
    entity.triangles.push(TriangleListPrimitive {
        pose: Some(pose(at)),
        points,
        color: Some(color),
        ..TriangleListPrimitive::default()
    });
}
