//! Signed separation of a capsule that lies along its x axis from a prism: that of the segment between the centres of
//! its ends, less the radius.
//!
//! The best of all directions is one of three: it leans towards an end, and then separates the prism from that end alone
//! as well as any (its signed distance); it is level with the segment, and then separates the prism's shadow along
//! the segment from a point (corners and edges of the shadow); or it is normal to a face of the prism. The
//! true distance, outside and inside.

use super::axis::{AxisKind, Best, Body};
use super::nearest::signed_distance;
use super::placed::Placed;
use super::{Prism, Separation};
use nalgebra::{Isometry3, Point3, Vector3};

/// The segment runs along this axis.
const EDGES: [usize; 1] = [0];
/// Below this distance from the segment's line a corner shows no direction, metres.
const NO_LENGTH_M: f32 = 1e-6;

/// Dimensions, metres.
struct Capsule {
    radius_m: f32,
    half_length_m: f32,
}

impl Body for Capsule {
    fn reach_m(&self, axis: &Vector3<f32>) -> f32 {
        libm::fabsf(axis.x) * self.half_length_m + axis.norm() * self.radius_m
    }

    fn farthest_m(&self, normal: &Vector3<f32>) -> Vector3<f32> {
        Vector3::x() * libm::copysignf(self.half_length_m, normal.x) + normal * self.radius_m
    }
}

/// Signed distance of a point (object frame, metres) from the capsule, metres.
pub fn point_separation_m(radius_m: f32, half_length_m: f32, p: &Vector3<f32>) -> f32 {
    let beyond_m = (libm::fabsf(p.x) - half_length_m).max(0.0);
    Vector3::new(beyond_m, p.y, p.z).norm() - radius_m
}

/// Signed separation of the prism from the capsule, or `None` as soon as it is certain to be `limit_m` or more, or if the
/// pose is not finite or the prism has no corner. See [`Separation`].
#[inline(never)]
pub fn separation_below(
    radius_m: f32,
    half_length_m: f32,
    object_from_link: &Isometry3<f32>,
    prism: &Prism,
    limit_m: f32,
) -> Option<Separation> {
    let placed = Placed::new(object_from_link, prism)?;
    let body = Capsule { radius_m, half_length_m };
    let mut best = Best::none();
    best.offer_prism_faces(&body, &placed);
    if best.distance_m >= limit_m {
        return None;
    }
    offer_ends(&body, object_from_link, prism, &mut best);
    if best.distance_m >= limit_m {
        return None;
    }
    offer_nearest_corner(&body, &placed, &mut best);
    best.offer_cap_edges(&body, &EDGES, &placed);
    best.offer_side_edges(&body, &EDGES, &placed);
    best.finish_below(&body, &placed, limit_m)
}

/// Each end alone, where the direction from the prism's nearest point to it is one in which no other point of the segment
/// reaches farther. Such a direction may as well turn with the link: see [`AxisKind::Link`].
fn offer_ends(body: &Capsule, object_from_link: &Isometry3<f32>, prism: &Prism, best: &mut Best) {
    for end_m in [body.half_length_m, -body.half_length_m] {
        let end = object_from_link.inverse_transform_point(&Point3::new(end_m, 0.0, 0.0)).coords;
        if let Some((from_end_m, away)) = signed_distance(prism, &end) {
            let normal = -(object_from_link.rotation * away);
            if normal.x * end_m > 0.0 {
                best.offer(from_end_m - body.radius_m, normal, AxisKind::Link);
            }
        }
    }
}

/// The corner of the prism's shadow along the segment that is the nearest to it.
fn offer_nearest_corner(body: &Capsule, placed: &Placed, best: &mut Best) {
    let mut nearest = (f32::MAX, Vector3::zeros());
    for corner in placed.corners() {
        let beside = Vector3::new(0.0, corner.y, corner.z);
        let distance_sq = beside.norm_squared();
        if distance_sq < nearest.0 {
            nearest = (distance_sq, beside);
        }
    }
    let length_m = libm::sqrtf(nearest.0);
    if length_m > NO_LENGTH_M {
        let normal = nearest.1 / length_m;
        best.offer(placed.lowest_m(&normal) - body.radius_m, normal, AxisKind::Object);
    }
}
