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
    /// Unit vector along each side, from its corner to the next; (1, 0) for a side without length.
    sides: [[f32; 2]; PRISM_CORNERS_MAX],
    centre_m: [f32; 3],
    radius_m: f32,
}

impl Prism {
    /// A prism over the polygon `corners_m` (metres, anticlockwise seen from +z, convex) between the heights `z_m`.
    /// What the separation functions need of it again and again is worked out here, at compile time for the hand's links.
    pub const fn new(corners_m: &'static [[f32; 2]], z_m: [f32; 2]) -> Self {
        let mut sides = [[1.0, 0.0]; PRISM_CORNERS_MAX];
        let (mut low, mut high) = ([f32::MAX; 2], [f32::MIN; 2]);
        let mut i = 0;
        while i < corners_m.len() {
            let from = corners_m[i];
            if i < PRISM_CORNERS_MAX {
                let to = corners_m[if i + 1 == corners_m.len() || i + 1 == PRISM_CORNERS_MAX { 0 } else { i + 1 }];
                let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
                let length_m = square_root(dx * dx + dy * dy);
                if length_m > 1e-6 {
                    sides[i] = [dx / length_m, dy / length_m];
                }
            }
            low = [low[0].min(from[0]), low[1].min(from[1])];
            high = [high[0].max(from[0]), high[1].max(from[1])];
            i += 1;
        }
        let half_height_m = 0.5 * (z_m[1] - z_m[0]);
        let centre_m = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (z_m[0] + z_m[1])];
        let mut radius_sq_m2 = 0.0_f32;
        let mut i = 0;
        while i < corners_m.len() {
            let (dx, dy) = (corners_m[i][0] - centre_m[0], corners_m[i][1] - centre_m[1]);
            radius_sq_m2 = radius_sq_m2.max(dx * dx + dy * dy);
            i += 1;
        }
        let radius_m = square_root(radius_sq_m2 + half_height_m * half_height_m);
        Self { corners_m, z_m, sides, centre_m, radius_m }
    }

    /// Centre and radius (metres, link frame) of a sphere that holds the whole prism: the smallest one about the
    /// centre of the prism's bounding box.
    pub fn bounding_sphere(&self) -> (Vector3<f32>, f32) {
        (Vector3::from(self.centre_m), self.radius_m)
    }

    /// Unit vector along each side, from its corner to the next; (1, 0) for a side without length.
    pub(super) fn sides(&self) -> &[[f32; 2]] {
        self.sides.get(..self.corners_m.len()).unwrap_or(&self.sides)
    }
}

/// Square root, correctly rounded, where no library can compute it: at compile time. Newton's method in `f64`, which is
/// more than twice as precise, so that rounding to `f32` afterwards is the only rounding that counts.
const fn square_root(x: f32) -> f32 {
    if x <= 0.0 {
        return 0.0;
    }
    let wide = x as f64;
    let mut root = if wide > 1.0 { wide } else { 1.0 };
    // Each step halves the distance until the method converges quadratically: enough for every positive f32.
    let mut step = 0;
    while step < 96 {
        root = 0.5 * (root + wide / root);
        step += 1;
    }
    root as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounding_sphere_holds_every_corner_and_touches_one() {
        let prism = Prism::new(&[[0.0, -0.01], [0.06, -0.01], [0.05, 0.01], [0.0, 0.02]], [-0.01, 0.02]);
        let (centre, radius) = prism.bounding_sphere();
        let mut farthest = 0.0_f32;
        for corner in prism.corners_m {
            for z in prism.z_m {
                farthest = farthest.max((Vector3::new(corner[0], corner[1], z) - centre).norm());
            }
        }
        assert!((farthest - radius).abs() < 1e-6, "farthest {farthest} radius {radius}");
    }

    #[test]
    fn the_square_root_for_compile_time_is_the_librarys() {
        let mut x = 1e-30_f32;
        while x < 1e30 {
            for y in [x, x * 1.234_567, x * 1.999_999_9] {
                assert_eq!(square_root(y).to_bits(), libm::sqrtf(y).to_bits(), "{y}");
            }
            x *= 1.013;
        }
        assert_eq!(square_root(0.0), 0.0);
    }
}
