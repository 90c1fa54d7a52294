//! A capsule that lies along its x axis: how far a point is from it.

use nalgebra::Vector3;

/// Signed distance of a point (object frame, metres) from the capsule, metres.
pub fn point_separation_m(radius_m: f32, half_length_m: f32, p: &Vector3<f32>) -> f32 {
    let beyond_m = (libm::fabsf(p.x) - half_length_m).max(0.0);
    Vector3::new(beyond_m, p.y, p.z).norm() - radius_m
}
