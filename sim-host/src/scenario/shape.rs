//! The shape of a body, from what a scene file says of it.

use super::format::ShapeFile;
use super::mesh;
use super::mistake::Mistake;
use super::polyhedron::Polyhedron;
use std::path::Path;
use tactus_common::shape::{Hull, ObjectShape};

/// Edges, heights and diameters of bodies, metres.
const LENGTH_M: [f32; 2] = [0.01, 1.0];
/// Most triangles of a mesh: a polyhedron of the few corners that a hull may have needs far fewer.
const TRIANGLES_MAX: usize = 4_000;

/// The shape that the body `of` has by its fields `shape` and `size_m`; paths of files are meant from `folder`.
///
/// # Errors
/// None or both are given, or a number or a mesh cannot be used; the field is named.
pub fn resolve(
    of: &str,
    shape: Option<&ShapeFile>,
    size_m: Option<&[f32; 3]>,
    folder: &Path,
) -> Result<ObjectShape, Mistake> {
    match (shape, size_m) {
        (Some(shape), None) => from_file(&format!("{of}.shape"), shape, folder),
        (None, Some(size_m)) => cuboid(&format!("{of}.size_m"), size_m),
        (Some(_), Some(_)) => Err(Mistake::new(format!("{of}.size_m"), "given beside shape; expected one of the two")),
        (None, None) => Err(Mistake::new(of, "no shape; expected `shape`, or `size_m` for a box")),
    }
}

fn from_file(field: &str, shape: &ShapeFile, folder: &Path) -> Result<ObjectShape, Mistake> {
    match shape {
        ShapeFile::Box { size_m } => cuboid(&format!("{field}.box.size_m"), size_m),
        ShapeFile::Cylinder { radius_m, height_m } => {
            check_length(&format!("{field}.cylinder.radius_m"), *radius_m, 0.5)?;
            check_length(&format!("{field}.cylinder.height_m"), *height_m, 1.0)?;
            Ok(ObjectShape::Cylinder { radius_m: *radius_m, half_height_m: height_m / 2.0 })
        }
        ShapeFile::Sphere { radius_m } => {
            check_length(&format!("{field}.sphere.radius_m"), *radius_m, 0.5)?;
            Ok(ObjectShape::Sphere { radius_m: *radius_m })
        }
        ShapeFile::Capsule { radius_m, length_m } => {
            check_length(&format!("{field}.capsule.radius_m"), *radius_m, 0.5)?;
            check_length(&format!("{field}.capsule.length_m"), *length_m, 1.0)?;
            let half_length_m = length_m / 2.0 - radius_m;
            if half_length_m <= 0.0 {
                let told = format!("{length_m}: expected more than twice the radius, {} m", 2.0 * radius_m);
                return Err(Mistake::new(format!("{field}.capsule.length_m"), told));
            }
            Ok(ObjectShape::Capsule { radius_m: *radius_m, half_length_m })
        }
        ShapeFile::Mesh { file, scale } => {
            if !(scale.is_finite() && *scale > 0.0) {
                let told = format!("{scale}: expected a finite number above zero");
                return Err(Mistake::new(format!("{field}.mesh.scale"), told));
            }
            convex(file, *scale, folder)
                .map_err(|what| Mistake::new(format!("{field}.mesh.file"), format!("{}: {what}", file.display())))
        }
    }
}

fn cuboid(field: &str, size_m: &[f32; 3]) -> Result<ObjectShape, Mistake> {
    for size in size_m {
        check_length(field, *size, 1.0)?;
    }
    Ok(ObjectShape::Cuboid { half_extents_m: size_m.map(|s| s / 2.0) })
}

/// `part`: what part of a whole diameter or edge the length is.
fn check_length(field: &str, length_m: f32, part: f32) -> Result<(), Mistake> {
    let [min, max] = LENGTH_M.map(|limit| limit * part);
    if (min..=max).contains(&length_m) {
        return Ok(());
    }
    let told = format!("{length_m}: expected a finite number above zero, from {min} to {max} m");
    Err(Mistake::new(field, told))
}

fn convex(file: &Path, scale: f32, folder: &Path) -> Result<ObjectShape, String> {
    let mesh = mesh::read(file, folder)?;
    if mesh.triangles.len() > TRIANGLES_MAX {
        return Err(format!("{} triangles; expected at most {TRIANGLES_MAX}", mesh.triangles.len()));
    }
    let polyhedron = Polyhedron::new(&mesh, f64::from(scale))?;
    let faces: Vec<Vec<u8>> = polyhedron
        .faces
        .iter()
        .map(|face| face.iter().map(|i| u8::try_from(*i).unwrap_or(u8::MAX)).collect())
        .collect();
    let hull = Hull::new(&polyhedron.corners_m, faces.iter().map(Vec::as_slice)).map_err(|fault| {
        format!("{} corners and {} faces that are no plain hull: {fault}", polyhedron.corners_m.len(), faces.len())
    })?;
    let size_m = hull.half_extents_m().map(|half| 2.0 * half);
    if !size_m.iter().all(|size| (LENGTH_M[0]..=LENGTH_M[1]).contains(size)) {
        let [x, y, z] = size_m;
        return Err(format!("{x:.4} x {y:.4} x {z:.4} m large; expected {} to {} m: scale?", LENGTH_M[0], LENGTH_M[1]));
    }
    Ok(ObjectShape::Convex(hull))
}
