//! A mesh as a convex solid: its faces, and its corners about its centroid.

use super::mesh::Mesh;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Deviation from a plane that counts as none, in parts of the solid's size: a file's digits and its author's rounding.
const FLAT: f64 = 1e-4;

/// A convex solid that stands as its mesh does.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    /// Corners about the centroid, metres.
    pub corners_m: Vec<[f32; 3]>,
    /// Indices of the corners of each face, anticlockwise from outside.
    pub faces: Vec<Vec<usize>>,
}

/// A face's plane: what lies in the solid has `normal . p <= offset`.
struct Plane {
    normal: Vector3<f64>,
    offset: f64,
}

impl Polyhedron {
    /// The solid that a mesh bounds, one unit of which is `scale` metres. The error is one line.
    ///
    /// # Errors
    /// The mesh is not closed, is flat, or is not convex: by how much, and where.
    pub fn new(mesh: &Mesh, scale: f64) -> Result<Self, String> {
        let corners: Vec<Vector3<f64>> = mesh.corners.iter().map(|c| Vector3::from(*c) * scale).collect();
        check_closed(mesh, &corners)?;
        let low = corners.iter().fold(Vector3::repeat(f64::INFINITY), |low, c| low.inf(c));
        let high = corners.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, c| high.sup(c));
        let size = (high - low).norm();
        let (volume, centroid) = volume_and_centroid(mesh, &corners, &low);
        if volume.abs() < FLAT * size * size * size {
            return Err(format!("encloses {:.3e} m^3, next to nothing for its size; expected a solid", volume.abs()));
        }
        let planes = planes(mesh, &corners, size, volume.signum());
        check_convex(&planes, &corners, FLAT * size)?;
        Ok(Self::between(&planes, &corners, &centroid, FLAT * size))
    }

    /// The faces in these planes; corners within a face or along an edge are left out.
    fn between(planes: &[Plane], corners: &[Vector3<f64>], centroid: &Vector3<f64>, flat_m: f64) -> Self {
        let mut polyhedron = Self { corners_m: Vec::new(), faces: Vec::new() };
        let mut kept: BTreeMap<usize, usize> = BTreeMap::new();
        for plane in planes {
            let on_plane = |c: &Vector3<f64>| (plane.normal.dot(c) - plane.offset).abs() <= 2.0 * flat_m;
            let on_face: Vec<usize> = (0..corners.len()).filter(|i| on_plane(&corners[*i])).collect();
            let face = outline(&on_face, corners, &plane.normal, flat_m);
            polyhedron.faces.push(
                face.into_iter()
                    .map(|index| {
                        *kept.entry(index).or_insert_with(|| {
                            polyhedron.corners_m.push((corners[index] - centroid).map(|x| x as f32).into());
                            polyhedron.corners_m.len() - 1
                        })
                    })
                    .collect(),
            );
        }
        polyhedron
    }
}

/// Every edge of a closed surface is passed once in each direction.
fn check_closed(mesh: &Mesh, corners: &[Vector3<f64>]) -> Result<(), String> {
    let mut passed: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for [a, b, c] in &mesh.triangles {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            *passed.entry(edge).or_insert(0) += 1;
        }
    }
    let open = passed.iter().find(|((a, b), count)| **count != 1 || passed.get(&(*b, *a)) != Some(&1));
    match open {
        None => Ok(()),
        Some(((a, b), _)) => Err(format!(
            "not a closed surface: the edge from {} to {} does not lie between two faces that are wound alike",
            at(&corners[*a]),
            at(&corners[*b])
        )),
    }
}

/// Sums over the pyramids from `about` to each triangle; the volume is negative if the triangles are wound clockwise.
fn volume_and_centroid(mesh: &Mesh, corners: &[Vector3<f64>], about: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let (mut volume, mut moment) = (0.0, Vector3::zeros());
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| corners[i] - about);
        let pyramid = a.dot(&b.cross(&c)) / 6.0;
        volume += pyramid;
        moment += (a + b + c) * (pyramid / 4.0);
    }
    (volume, about + moment / volume)
}

/// The planes of the faces, each once: largest triangles first, so that slivers do not decide.
fn planes(mesh: &Mesh, corners: &[Vector3<f64>], size: f64, outward: f64) -> Vec<Plane> {
    let mut areas: Vec<(f64, Vector3<f64>, [Vector3<f64>; 3])> = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| corners[i]);
            let normal = (b - a).cross(&(c - a)) * outward;
            (normal.norm(), normal, [a, b, c])
        })
        .collect();
    areas.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut planes: Vec<Plane> = Vec::new();
    for (double_area, normal, triangle) in areas {
        if double_area < FLAT * FLAT * size * size {
            continue;
        }
        let normal = normal / double_area;
        let lies_in = |plane: &Plane| {
            let flat = |c: &Vector3<f64>| (plane.normal.dot(c) - plane.offset).abs() <= FLAT * size;
            plane.normal.dot(&normal) > 0.0 && triangle.iter().all(flat)
        };
        if !planes.iter().any(lies_in) {
            planes.push(Plane { normal, offset: normal.dot(&triangle[0]) });
        }
    }
    planes
}

/// No corner lies outside the plane of any face.
fn check_convex(planes: &[Plane], corners: &[Vector3<f64>], flat_m: f64) -> Result<(), String> {
    let mut worst = (flat_m, None);
    for plane in planes {
        for corner in corners {
            let outside_m = plane.normal.dot(corner) - plane.offset;
            if outside_m > worst.0 {
                worst = (outside_m, Some((corner, plane)));
            }
        }
    }
    match worst {
        (_, None) => Ok(()),
        (outside_m, Some((corner, plane))) => Err(format!(
            "not convex: the corner {} lies {:.2} mm outside the face with the normal ({:.2}, {:.2}, {:.2})",
            at(corner),
            outside_m * 1e3,
            plane.normal.x,
            plane.normal.y,
            plane.normal.z
        )),
    }
}

/// The corners of a convex face anticlockwise about its normal, those along its edges left out.
fn outline(on_face: &[usize], corners: &[Vector3<f64>], normal: &Vector3<f64>, flat_m: f64) -> Vec<usize> {
    let middle = on_face.iter().map(|i| corners[*i]).sum::<Vector3<f64>>() / on_face.len().max(1) as f64;
    let across = if normal.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let u = normal.cross(&across).normalize();
    let v = normal.cross(&u);
    let angle = |i: usize| libm::atan2((corners[i] - middle).dot(&v), (corners[i] - middle).dot(&u));
    let mut around: Vec<usize> = on_face.to_vec();
    around.sort_by(|a, b| angle(*a).total_cmp(&angle(*b)));
    let mut i = 0;
    while around.len() > 3 && i < around.len() {
        let n = around.len();
        let (before, here, after) =
            (corners[around[(i + n - 1) % n]], corners[around[i]], corners[around[(i + 1) % n]]);
        let edge = after - before;
        let beyond_m = edge.cross(normal).normalize().dot(&(here - before));
        if beyond_m <= flat_m {
            around.remove(i);
            i = i.saturating_sub(1);
        } else {
            i += 1;
        }
    }
    around
}

/// A place in the solid's own coordinates, metres.
fn at(p: &Vector3<f64>) -> String {
    format!("({:.4}, {:.4}, {:.4}) m", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A box of triangles; `shift_m` moves one corner of the top outwards.
    fn cube(size_m: [f64; 3], shift_m: [f64; 3]) -> Mesh {
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { size_m[k] } else { 0.0 });
        let mut corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
        corners[7] = core::array::from_fn(|k| corners[7][k] + shift_m[k]);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Mesh { corners, triangles }
    }

    proptest! {
        #[test]
        fn a_box_has_eight_corners_about_its_middle_and_six_faces_of_four(
            size_mm in [10.0..400.0_f64, 10.0..400.0, 10.0..400.0], inverted in any::<bool>()
        ) {
            let mut mesh = cube(size_mm, [0.0; 3]);
            if inverted {
                mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            let polyhedron = Polyhedron::new(&mesh, 1e-3).unwrap();
            prop_assert_eq!((polyhedron.corners_m.len(), polyhedron.faces.len()), (8, 6));
            prop_assert!(polyhedron.faces.iter().all(|face| face.len() == 4));
            for corner in &polyhedron.corners_m {
                for (x, size) in corner.iter().zip(size_mm) {
                    prop_assert!((f64::from(x.abs()) - size * 5e-4).abs() < 1e-6);
                }
            }
            // Anticlockwise from outside: each face's normal points away from the centroid.
            for face in &polyhedron.faces {
                let [a, b, c] = [face[0], face[1], face[2]].map(|i| Vector3::from(polyhedron.corners_m[i]));
                prop_assert!((b - a).cross(&(c - b)).dot(&a) > 0.0);
            }
        }
    }

    #[test]
    fn a_corner_within_an_edge_or_a_face_is_left_out() {
        let mut mesh = cube([1.0; 3], [0.0; 3]);
        // The middle of the bottom's diagonal lies within that face.
        mesh.corners.push([0.5, 0.5, 0.0]);
        mesh.triangles.retain(|t| *t != [0, 2, 3] && *t != [0, 3, 1]);
        mesh.triangles.extend([[0, 2, 8], [2, 3, 8], [3, 1, 8], [1, 0, 8]]);
        let polyhedron = Polyhedron::new(&mesh, 1.0).unwrap();
        assert_eq!((polyhedron.corners_m.len(), polyhedron.faces.len()), (8, 6));
    }

    #[test]
    fn a_dent_is_refused_with_its_depth_and_place() {
        let told = Polyhedron::new(&cube([0.1; 3], [-0.03, -0.03, -0.03]), 1.0).unwrap_err();
        assert!(told.starts_with("not convex: the corner ") && told.contains(" mm outside"), "{told}");
        let valley = Polyhedron::new(&cube([0.1; 3], [0.0, 0.0, -0.03]), 1.0).unwrap_err();
        assert!(valley.starts_with("not convex: the corner "), "{valley}");
    }

    #[test]
    fn an_open_or_a_flat_surface_is_refused() {
        let mut open = cube([0.1; 3], [0.0; 3]);
        open.triangles.pop();
        assert!(Polyhedron::new(&open, 1.0).unwrap_err().contains("not a closed surface: the edge from"));
        let mut turned = cube([0.1; 3], [0.0; 3]);
        turned.triangles[0].swap(1, 2);
        assert!(Polyhedron::new(&turned, 1.0).unwrap_err().contains("wound alike"));
        let flat = Polyhedron::new(&cube([0.1, 0.1, 1e-9], [0.0; 3]), 1.0).unwrap_err();
        assert!(flat.contains("next to nothing"), "{flat}");
    }
}
