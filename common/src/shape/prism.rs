//! Right prism over a convex polygon: the collision shape of every hand link.

use nalgebra::Vector3;

/// Most corners that a link's polygon may have; further ones are not seen by the separation functions.
pub const PRISM_CORNERS_MAX: usize = 16;

/// A convex polygon in the local x-y plane, extruded along the local z axis.
///
/// Every hand link is one prism in its own link frame (boxes are prisms too), so that world, planner and
/// estimator agree on the cross-sections: a study showed that links modelled 6 mm too thin spoil most updates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// Corners of the polygon, metres, anticlockwise seen from +z, convex.
    pub corners_m: &'static [[f32; 2]],
    /// Lower and upper face, metres along z.
    pub z_m: [f32; 2],
}

impl Prism {
    /// Centre and radius (metres, link frame) of a sphere that holds the whole prism: the smallest one about the
    /// centre of the prism's bounding box.
    pub fn bounding_sphere(&self) -> (Vector3<f32>, f32) {
        let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
        for corner in self.corners_m {
            for axis in 0..2 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let half_height_m = 0.5 * (self.z_m[1] - self.z_m[0]);
        let centre =
            Vector3::new(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (self.z_m[0] + self.z_m[1]));
        let mut radius_sq_m2 = 0.0_f32;
        for corner in self.corners_m {
            let (dx, dy) = (corner[0] - centre.x, corner[1] - centre.y);
            radius_sq_m2 = radius_sq_m2.max(dx * dx + dy * dy);
        }
        (centre, libm::sqrtf(radius_sq_m2 + half_height_m * half_height_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounding_sphere_holds_every_corner_and_touches_one() {
        let prism = Prism { corners_m: &[[0.0, -0.01], [0.06, -0.01], [0.05, 0.01], [0.0, 0.02]], z_m: [-0.01, 0.02] };
        let (centre, radius) = prism.bounding_sphere();
        let mut farthest = 0.0_f32;
        for corner in prism.corners_m {
            for z in prism.z_m {
                farthest = farthest.max((Vector3::new(corner[0], corner[1], z) - centre).norm());
            }
        }
        assert!((farthest - radius).abs() < 1e-6, "farthest {farthest} radius {radius}");
    }
}
