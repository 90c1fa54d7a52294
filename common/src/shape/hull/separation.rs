//! Signed separation of a hull from a prism by a separating-axis test: that of two convex polyhedra, as for the box.
//!
//! Of the many pairs of edges only those give an axis whose arcs on the sphere of normals cross (Gregorius, *The separating
//! axis test between convex polyhedra*, GDC 2013). The edges of one polygon side together have half a great circle, so an edge
//! of the hull crosses it where the side's direction is uphill from one of its faces and downhill from the other; the
//! crossing is the axis, and both edges are its supports: no search for a corner, and no root for most.
//!
//! Cost for a prism of `n` corners and a hull of `F` faces, `E` edges and `V` corners: `F (5 n + 10)` for the hull's faces,
//! `n (5 V + 15)` for the prism's, `10 n F` for the faces' slopes, `5 n E` to look for crossings: 12 kflop for a fingertip and
//! the largest hull.

use super::{HULL_EDGES_MAX, HULL_FACES_MAX, Hull, gathered};
use crate::shape::axis::{AxisKind, Best, Body};
use crate::shape::placed::Placed;
use crate::shape::{Prism, Separation};
use heapless::Vec;
use nalgebra::{Isometry3, Vector3};

/// Squared length of a crossing below which it is no axis: the product of the squared sines of the angles between the faces
/// and between the edges.
const CROSSING_SQ_MIN: f32 = 1e-6;
/// A point that far above a plane counts as below it, metres.
const ROUNDING_M: f32 = 1e-7;

impl Body for Hull {
    fn reach_m(&self, axis: &Vector3<f32>) -> f32 {
        let mut reach_m = f32::MIN;
        for [x, y, z] in self.corners_m() {
            let d = x * axis.x + y * axis.y + z * axis.z;
            if d > reach_m {
                reach_m = d;
            }
        }
        reach_m
    }

    fn farthest_m(&self, normal: &Vector3<f32>) -> Vector3<f32> {
        let mut farthest = (f32::MIN, Vector3::zeros());
        for corner in self.corners_m() {
            let corner = Vector3::from(*corner);
            let d = corner.dot(normal);
            if d > farthest.0 {
                farthest = (d, corner);
            }
        }
        farthest.1
    }
}

/// An edge of the hull: a corner on it, its direction (of any length), and the normals on both sides with their indices.
struct Edge {
    corner: Vector3<f32>,
    along: Vector3<f32>,
    faces: [usize; 2],
    normals: [Vector3<f32>; 2],
}

type Edges = Vec<Edge, HULL_EDGES_MAX>;

/// Signed separation of the prism from the hull, or `None` as soon as it is certain to be `limit_m` or more, or if the pose is
/// not finite or the prism has no corner. See [`Separation`].
#[inline(never)]
pub fn separation_below(
    hull: &Hull,
    object_from_link: &Isometry3<f32>,
    prism: &Prism,
    limit_m: f32,
) -> Option<Separation> {
    let placed = Placed::new(object_from_link, prism)?;
    let mut best = Best::none();
    for (normal, offset_m) in hull.planes() {
        best.offer(placed.lowest_m(&normal) - offset_m, normal, AxisKind::Object);
    }
    if best.distance_m >= limit_m {
        return None;
    }
    if is_opposite_face(hull, &placed, &best) {
        return Some(best.finish(hull, &placed));
    }
    best.offer_prism_faces(hull, &placed);
    if best.distance_m >= limit_m {
        return None;
    }
    let edges = edges(hull);
    offer_cap_edges(hull, &edges, &placed, &mut best);
    offer_side_edges(&edges, &placed, &mut best);
    best.finish_below(hull, &placed, limit_m)
}

/// Is the prism's nearest corner straight above the face that separates best? Then the bodies are that far apart, and no
/// axis separates them by more.
fn is_opposite_face(hull: &Hull, placed: &Placed, best: &Best) -> bool {
    if !(best.distance_m > 0.0 && best.distance_m.is_finite()) {
        return false;
    }
    let foot = placed.lowest_corner(&best.normal) - best.normal * best.distance_m;
    hull.planes().all(|(normal, offset_m)| normal.dot(&foot) <= offset_m + ROUNDING_M)
}

fn edges(hull: &Hull) -> Edges {
    let edge = |(faces, ends): ([usize; 2], [Vector3<f32>; 2])| {
        let normals = [hull.normal(faces[0])?, hull.normal(faces[1])?];
        Some(Edge { corner: ends[0], along: ends[1] - ends[0], faces, normals })
    };
    gathered(hull.edges_between().filter_map(edge))
}

/// Coordinates of the faces' normals along an axis.
fn slopes(hull: &Hull, axis: &Vector3<f32>) -> [f32; HULL_FACES_MAX] {
    let mut slopes = [0.0; HULL_FACES_MAX];
    for (slope, (normal, _)) in slopes.iter_mut().zip(hull.planes()) {
        *slope = normal.dot(axis);
    }
    slopes
}

/// Where the normals from one face of an edge to the other are level, given how much each of the two rises: not brought to
/// unit length. `None` if they are nowhere, or all the way.
fn crossing(edge: &Edge, slopes: &[f32; HULL_FACES_MAX]) -> Option<([f32; 2], Vector3<f32>)> {
    let [a, b] = [*slopes.get(edge.faces[0])?, *slopes.get(edge.faces[1])?];
    if a * b >= 0.0 {
        return None;
    }
    let weights = [libm::fabsf(b), libm::fabsf(a)];
    Some((weights, edge.normals[0] * weights[0] + edge.normals[1] * weights[1]))
}

/// Edges of the two polygons against edges of the hull.
fn offer_cap_edges(hull: &Hull, edges: &Edges, placed: &Placed, best: &mut Best) {
    for (side, corner) in placed.sides() {
        let (along, outward) = (slopes(hull, &side.along), slopes(hull, &side.outward));
        for edge in edges {
            let Some((weights, axis)) = crossing(edge, &along) else { continue };
            let [a, b] = edge.faces.map(|face| outward.get(face).copied().unwrap_or(0.0));
            if weights[0] * a + weights[1] * b >= 0.0 {
                continue;
            }
            let lowest = placed.lowest_on_side_m(&axis, corner);
            offer(edge, &axis, lowest, &side.along, best);
        }
    }
}

/// Edges of the prism along its own axis against edges of the hull.
fn offer_side_edges(edges: &Edges, placed: &Placed, best: &mut Best) {
    let up = placed.axes[2];
    for edge in edges {
        let [a, b] = edge.normals.map(|normal| normal.dot(&up));
        if a * b < 0.0 {
            let axis = edge.normals[0] * libm::fabsf(b) + edge.normals[1] * libm::fabsf(a);
            offer(edge, &axis, placed.lowest_m(&axis), &up, best);
        }
    }
}

/// Offers an axis of any length along which `lowest` is the prism's smallest coordinate, and the edge the hull's largest.
fn offer(edge: &Edge, axis: &Vector3<f32>, lowest: f32, of_link: &Vector3<f32>, best: &mut Best) {
    let length_sq = axis.norm_squared();
    let scaled = lowest - axis.dot(&edge.corner);
    if length_sq < CROSSING_SQ_MIN || best.surpasses(scaled, length_sq) {
        return;
    }
    let length = libm::sqrtf(length_sq);
    let sign = if edge.along.cross(of_link).dot(axis) > 0.0 { 1.0 } else { -1.0 };
    best.offer(scaled / length, axis / length, AxisKind::Edges { of_object: edge.along, of_link: *of_link, sign });
}
