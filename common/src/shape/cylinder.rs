//! Signed separation of an upright cylinder from a prism by a separating-axis test.
//!
//! A direction that separates the two better than any near it is one of these: the cylinder's axis; the normal of a face of
//! the prism; a level direction, at a right angle to an edge of the prism or through a corner of it; or one at a
//! right angle to an edge of the prism and to the rim of the cylinder (`rim.rs`). If the two are apart, one of these
//! separates them, by the argument for polyhedra: the directions that do are a cone, and one that meets none of these would
//! be that of a lone corner against a rim, which reaches the axis or the level. Yaw changes nothing.

use super::axis::{AxisKind, Best, Body};
use super::placed::Placed;
use super::{Prism, Separation};
use nalgebra::{Isometry3, Vector3};

mod rim;

/// The side's lines run along this axis.
const EDGES: [usize; 1] = [2];
/// Below this distance from the axis a corner shows no direction, metres.
const NO_LENGTH_M: f32 = 1e-6;

/// Dimensions, metres.
struct Cylinder {
    radius_m: f32,
    half_height_m: f32,
}

impl Body for Cylinder {
    fn reach_m(&self, axis: &Vector3<f32>) -> f32 {
        let level = libm::sqrtf(axis.x * axis.x + axis.y * axis.y);
        level * self.radius_m + libm::fabsf(axis.z) * self.half_height_m
    }

    fn farthest_m(&self, normal: &Vector3<f32>) -> Vector3<f32> {
        let level = libm::sqrtf(normal.x * normal.x + normal.y * normal.y);
        let out = if level > 0.0 { self.radius_m / level } else { 0.0 };
        Vector3::new(normal.x * out, normal.y * out, libm::copysignf(self.half_height_m, normal.z))
    }
}

/// Separation of a point (object frame, metres) from the cylinder: the larger of those from its side and from its two
/// ends, metres.
pub fn point_separation_m(radius_m: f32, half_height_m: f32, p: &Vector3<f32>) -> f32 {
    (libm::sqrtf(p.x * p.x + p.y * p.y) - radius_m).max(libm::fabsf(p.z) - half_height_m)
}

/// Signed separation of the prism from the cylinder, or `None` as soon as it is certain to be `limit_m` or more, or if the
/// pose is not finite or the prism has no corner. See [`Separation`].
#[inline(never)]
pub fn separation_below(
    radius_m: f32,
    half_height_m: f32,
    object_from_link: &Isometry3<f32>,
    prism: &Prism,
    limit_m: f32,
) -> Option<Separation> {
    let placed = Placed::new(object_from_link, prism)?;
    let body = Cylinder { radius_m, half_height_m };
    let mut best = Best::none();
    offer_ends(&body, &placed, &mut best);
    offer_nearest_corner(&body, &placed, &mut best);
    if best.distance_m >= limit_m {
        return None;
    }
    if !is_opposite(&body, &placed, &best) {
        best.offer_prism_faces(&body, &placed);
        if best.distance_m >= limit_m {
            return None;
        }
        best.offer_cap_edges(&body, &EDGES, &placed);
        best.offer_side_edges(&body, &EDGES, &placed);
        rim::offer(&body, &placed, &mut best);
    }
    let found = best.finish_below(&body, &placed, limit_m)?;
    let [x, y, _] = found.gradient_object;
    Some(Separation { gradient_object: [x, y, 0.0], ..found })
}

fn offer_ends(body: &Cylinder, placed: &Placed, best: &mut Best) {
    let (low, high) = placed.extent(&Vector3::z());
    best.offer(low - body.half_height_m, Vector3::z(), AxisKind::Object);
    best.offer(-high - body.half_height_m, -Vector3::z(), AxisKind::Object);
}

/// The level direction through the corner that is the nearest to the axis. Where that corner is not the nearest point of the
/// prism's shadow on the table, an edge offers more.
fn offer_nearest_corner(body: &Cylinder, placed: &Placed, best: &mut Best) {
    let mut nearest = (f32::MAX, Vector3::zeros());
    for corner in placed.corners() {
        let level = Vector3::new(corner.x, corner.y, 0.0);
        let distance_sq = level.norm_squared();
        if distance_sq < nearest.0 {
            nearest = (distance_sq, level);
        }
    }
    let length_m = libm::sqrtf(nearest.0);
    if length_m > NO_LENGTH_M {
        let normal = nearest.1 / length_m;
        best.offer(placed.lowest_m(&normal) - body.radius_m, normal, AxisKind::Object);
    }
}

/// Is the prism's nearest corner straight above the end, or straight beside the side, that separates best? Then the bodies are
/// that far apart, and no axis separates them by more.
fn is_opposite(body: &Cylinder, placed: &Placed, best: &Best) -> bool {
    if !(best.distance_m > 0.0 && best.distance_m.is_finite()) {
        return false;
    }
    let corner = placed.lowest_corner(&best.normal);
    let level_sq = corner.x * corner.x + corner.y * corner.y;
    if best.normal.z != 0.0 {
        level_sq <= body.radius_m * body.radius_m
    } else {
        let along = corner.x * best.normal.x + corner.y * best.normal.y;
        libm::fabsf(corner.z) <= body.half_height_m && level_sq - along * along <= NO_LENGTH_M * NO_LENGTH_M
    }
}
