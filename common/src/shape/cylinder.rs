//! An upright cylinder: how far a point is from it.

use nalgebra::Vector3;

/// Separation of a point (object frame, metres) from the cylinder: the larger of those from its side and from its two
/// ends, metres.
pub fn point_separation_m(radius_m: f32, half_height_m: f32, p: &Vector3<f32>) -> f32 {
    (libm::hypotf(p.x, p.y) - radius_m).max(libm::fabsf(p.z) - half_height_m)
}
