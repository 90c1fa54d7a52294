//! A sphere: how far a point is from it.

use nalgebra::Vector3;

/// Signed distance of a point (object frame, metres) from the sphere, metres.
pub fn point_separation_m(radius_m: f32, p: &Vector3<f32>) -> f32 {
    p.norm() - radius_m
}
