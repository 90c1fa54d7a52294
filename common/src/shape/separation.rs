//! Signed separation of a hand link from an object, with its gradient over the object's planar pose.

use nalgebra::Vector3;

/// How far a hand link is from an object, and how that changes as the object moves on the table.
///
/// The distance is the largest separation along any of the candidate axes of a separating-axis test: positive and
/// never larger than the true distance outside, zero exactly where the bodies touch, minus the penetration depth
/// inside. It changes by at most the distance that either body is shifted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Signed separation, metres; negative = penetration.
    pub distance_m: f32,
    /// Unit axis of least penetration, from the object to the link, object frame.
    pub normal_object: Vector3<f32>,
    /// Corner of link or object (object frame, metres) that is the deepest along the axis.
    pub witness_object_m: Vector3<f32>,
    /// Change of `distance_m` with a shift of the object along its own x and y (m/m) and a turn of it about the
    /// vertical through its origin (m/rad), in this order; the link stays.
    pub gradient_object: [f32; 3],
}

impl Separation {
    /// The gradient over `(x, y, phi)` of the object's pose in the world, for an object at yaw `phi` given as
    /// `(sin phi, cos phi)`.
    pub fn gradient_world(&self, sin_cos_phi: (f32, f32)) -> [f32; 3] {
        let (s, c) = sin_cos_phi;
        let [gx, gy, gphi] = self.gradient_object;
        [c * gx - s * gy, s * gx + c * gy, gphi]
    }
}
