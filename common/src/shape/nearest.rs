//! Signed distance of a point from a prism.

use super::{PRISM_CORNERS_MAX, Prism};
use nalgebra::Vector3;

/// Below this length a vector has no direction, metres.
const NO_LENGTH_M: f32 = 1e-7;

/// Distance of the point `p` (link frame, metres) from the prism, minus its depth inside, and the unit vector away from
/// the prism's nearest point (from the nearest face, inside). Exact, by the polygon and the interval that the prism is the
/// product of. `None` for a point that is no number, or a prism without corners.
pub(super) fn signed_distance(prism: &Prism, p: &Vector3<f32>) -> Option<(f32, Vector3<f32>)> {
    if !p.sum().is_finite() {
        return None;
    }
    let (beside_m, sideways) = from_polygon(prism, [p.x, p.y])?;
    let sideways = Vector3::new(sideways[0], sideways[1], 0.0);
    let (above_m, below_m) = (p.z - prism.z_m[1], prism.z_m[0] - p.z);
    let (beyond_m, upwards) = if above_m > below_m { (above_m, Vector3::z()) } else { (below_m, -Vector3::z()) };
    if beside_m > 0.0 && beyond_m > 0.0 {
        let away = sideways * beside_m + upwards * beyond_m;
        let distance_m = away.norm();
        return Some(if distance_m > NO_LENGTH_M { (distance_m, away / distance_m) } else { (distance_m, sideways) });
    }
    Some(if beside_m > beyond_m { (beside_m, sideways) } else { (beyond_m, upwards) })
}

/// The same in the plane of the polygon.
fn from_polygon(prism: &Prism, [x, y]: [f32; 2]) -> Option<(f32, [f32; 2])> {
    let corners = prism.corners_m.iter().take(PRISM_CORNERS_MAX);
    let next = corners.clone().skip(1).chain(prism.corners_m.first());
    // The side that the point is the farthest outside of, and the nearest point of the boundary.
    let mut outermost = (f32::MIN, [0.0; 2]);
    let mut nearest = (f32::MAX, [0.0; 2]);
    for ((from, to), [ax, ay]) in corners.zip(next).zip(prism.sides()) {
        let (dx, dy) = (x - from[0], y - from[1]);
        let outside_m = dx * ay - dy * ax;
        if outside_m > outermost.0 {
            outermost = (outside_m, [*ay, -ax]);
        }
        let length_m = (to[0] - from[0]) * ax + (to[1] - from[1]) * ay;
        let at_m = (dx * ax + dy * ay).clamp(0.0, length_m.max(0.0));
        let away = [dx - at_m * ax, dy - at_m * ay];
        let distance_sq = away[0] * away[0] + away[1] * away[1];
        if distance_sq < nearest.0 {
            nearest = (distance_sq, away);
        }
    }
    if outermost.0 == f32::MIN {
        return None;
    }
    let distance_m = libm::sqrtf(nearest.0);
    if outermost.0 <= 0.0 || distance_m <= NO_LENGTH_M {
        return Some(outermost);
    }
    Some((distance_m, nearest.1.map(|c| c / distance_m)))
}
