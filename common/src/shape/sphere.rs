//! Signed separation of a sphere from a prism: that of its centre, less the radius. The true distance, outside and inside.

use super::nearest::signed_distance;
use super::{Prism, Separation};
use nalgebra::{Isometry3, Point3, Vector3};

/// Signed distance of a point (object frame, metres) from the sphere, metres.
pub fn point_separation_m(radius_m: f32, p: &Vector3<f32>) -> f32 {
    p.norm() - radius_m
}

/// Signed separation of the prism from the sphere, or `None` if it is `limit_m` or more, or if the pose is not finite
/// or the prism has no corner. See [`Separation`].
pub fn separation_below(
    radius_m: f32,
    object_from_link: &Isometry3<f32>,
    prism: &Prism,
    limit_m: f32,
) -> Option<Separation> {
    let centre = object_from_link.inverse_transform_point(&Point3::origin()).coords;
    let (from_centre_m, away) = signed_distance(prism, &centre)?;
    let distance_m = from_centre_m - radius_m;
    (distance_m < limit_m).then(|| {
        let normal = -(object_from_link.rotation * away);
        Separation {
            distance_m,
            normal_object: normal,
            witness_object_m: normal * from_centre_m,
            // No turn changes a sphere.
            gradient_object: [-normal.x, -normal.y, 0.0],
        }
    })
}
