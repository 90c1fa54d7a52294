//! What a recording's scene entities are made of.

use super::frames::{Pose, Tracks};
use super::packed::Packed;
use super::payload::{Body, Role, Shape, Solid};
use crate::recording::scene::{BELIEVED, WORLD};
use anyhow::Context;
use foxglove::messages::{self as fox, SceneEntity, TriangleListPrimitive};

/// A body of a scene entity; `None` if it has no solid in it.
///
/// # Errors
/// Its frame is none of the recording's.
pub fn body(entity: &SceneEntity, frames: &Tracks) -> anyhow::Result<Option<Body>> {
    let shapes = shapes(entity);
    if shapes.is_empty() {
        return Ok(None);
    }
    let name = entity.frame_id.as_str();
    let frame = match name {
        WORLD | BELIEVED => None,
        _ => Some(frames.find(name).with_context(|| format!("no frame {name}, in which {} is", entity.id))?),
    };
    Ok(Some(Body { name: entity.id.clone(), role: role(entity), frame, shapes }))
}

/// What it is, by the entity's metadata.
fn role(entity: &SceneEntity) -> Role {
    let kind = entity.metadata.iter().find(|pair| pair.key == "kind").map_or("", |pair| pair.value.as_str());
    match kind {
        "arm" => Role::Arm,
        "hand" => Role::Hand,
        "table" => Role::Table,
        "object" => Role::Truth,
        "belief" => Role::Belief,
        "loose" => Role::Loose,
        _ => Role::Obstacle,
    }
}

fn shapes(entity: &SceneEntity) -> Vec<Shape> {
    let boxes = entity.cubes.iter().map(|c| (&c.pose, Solid::Box { size_m: size(&c.size) }));
    let spheres = entity.spheres.iter().map(|s| (&s.pose, Solid::Sphere { size_m: size(&s.size) }));
    let cylinders = entity.cylinders.iter().map(|c| {
        let [bottom, top] = [c.bottom_scale, c.top_scale].map(|scale| scale as f32);
        (&c.pose, Solid::Cylinder { size_m: size(&c.size), bottom, top })
    });
    let meshes = entity.triangles.iter().map(|t| (&t.pose, mesh(t)));
    let placed = boxes.chain(spheres).chain(cylinders).chain(meshes);
    placed.map(|(at, solid)| Shape { pose: pose(at), solid }).collect()
}

fn mesh(list: &TriangleListPrimitive) -> Solid {
    let corners: Vec<f32> = list.points.iter().flat_map(|p| [p.x, p.y, p.z]).map(|v| v as f32).collect();
    let triangles = (!list.indices.is_empty()).then(|| Packed::counts(list.indices.iter().copied()));
    let reach_m = corners.chunks(3).map(|corner| libm::hypotf(corner[0], corner[1])).fold(0.0, f32::max);
    Solid::Mesh { vertices_m: Packed::quantised(&corners), triangles, reach_m }
}

fn size(size: &Option<fox::Vector3>) -> [f32; 3] {
    size.map_or([0.0; 3], |s| [s.x, s.y, s.z].map(|v| v as f32))
}

/// A pose as the page takes it; where there is none, none was meant.
pub fn pose(pose: &Option<fox::Pose>) -> Pose {
    let pose = pose.unwrap_or_default();
    let at = pose.position.unwrap_or_default();
    let turn = pose.orientation.unwrap_or(fox::Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
    [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w].map(|v| v as f32)
}
