//! How a hand is laid out over an object: across which sides, and how high.

use core::f32::consts::FRAC_PI_2;
use nalgebra::Vector3;
use tactus_common::pose::PlanarPose;
use tactus_common::shape::{Hull, ObjectShape};

/// Palm above the object's top face, metres: the inner links, closed across 0.1 m, need 30 mm (facts 2.6), and fully open
/// fingers hang 35 mm below the palm.
const PALM_HEIGHT_M: f32 = 0.046;
/// Palm above the table, metres: a closing finger's lowest point comes 108 mm below the palm, at an inner angle of 1.0 rad
/// (the kinematics; a test holds it), and 9 mm remain for the errors of arm and table.
const PALM_OVER_TABLE_M: f32 = 0.117;
/// A face of a hull that leans by no more than this sine is a side to grasp across: 17 degrees.
const LEANING_MAX: f32 = 0.3;

/// The rectangle on the table that a hand is laid out about, in the object's frame; its y axis runs across the sides that are
/// the nearest to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Its middle, metres, and the yaw of its x axis, radians.
    middle: PlanarPose,
    /// Half its sides along its own x and y, metres.
    pub half_m: [f32; 2],
}

impl Footprint {
    /// That of an object.
    pub fn of(shape: &ObjectShape) -> Self {
        let [half_x_m, half_y_m, _] = shape.half_extents_m();
        let bounding = Self { middle: PlanarPose::default(), half_m: [half_x_m, half_y_m] };
        match shape {
            ObjectShape::Convex(hull) => of_hull(hull).unwrap_or(bounding),
            _ if half_x_m < half_y_m => {
                Self { middle: PlanarPose::new(0.0, 0.0, FRAC_PI_2), half_m: [half_y_m, half_x_m] }
            }
            _ => bounding,
        }
    }

    /// A pose given in the rectangle's frame, in the object's.
    pub fn place(&self, local: PlanarPose) -> PlanarPose {
        self.middle.compose(&local)
    }
}

/// Palm above an object's top, metres.
pub fn palm_height_m(shape: &ObjectShape) -> f32 {
    PALM_HEIGHT_M.max(PALM_OVER_TABLE_M - shape.top_height_m())
}

/// Across the upright face that has the least width of the hull behind it; `None` if there is no upright face.
fn of_hull(hull: &Hull) -> Option<Footprint> {
    let mut narrowest: Option<(f32, Vector3<f32>)> = None;
    for (normal, _) in hull.planes() {
        let level = Vector3::new(normal.x, normal.y, 0.0);
        if libm::fabsf(normal.z) <= LEANING_MAX {
            let across = level / level.norm();
            let [low_m, high_m] = extent_m(hull, &across);
            // The first of equals, whatever the rounding.
            if narrowest.is_none_or(|(width_m, _)| high_m - low_m < width_m - 1e-5) {
                narrowest = Some((high_m - low_m, across));
            }
        }
    }
    let (width_m, across) = narrowest?;
    let along = Vector3::new(across.y, -across.x, 0.0);
    let ([low_m, high_m], [from_m, to_m]) = (extent_m(hull, &along), extent_m(hull, &across));
    let middle = along * (0.5 * (low_m + high_m)) + across * (0.5 * (from_m + to_m));
    let yaw_rad = libm::atan2f(along.y, along.x);
    let half_m = [0.5 * (high_m - low_m), 0.5 * width_m];
    Some(Footprint { middle: PlanarPose::new(middle.x, middle.y, yaw_rad), half_m })
}

/// From where to where a hull reaches along an axis, metres.
fn extent_m(hull: &Hull, axis: &Vector3<f32>) -> [f32; 2] {
    let along = hull.corners_m().iter().map(|corner| axis.dot(&Vector3::from(*corner)));
    along.fold([f32::MAX, f32::MIN], |[low, high], d| [low.min(d), high.max(d)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::{FRAC_PI_3, FRAC_PI_6};
    use nalgebra::{Isometry3, Point3};
    use tactus_common::robot::hand::{self, HandAngles};
    use tactus_common::robot::tables::PALM_FACE_Z_M;
    use tactus_common::robot::{HandLink, hand_prism};

    fn hexagonal_prism() -> ObjectShape {
        ObjectShape::Convex(Hull::regular_prism(6, 0.05 / libm::cosf(FRAC_PI_6), 0.075).unwrap())
    }

    #[test]
    fn a_box_is_taken_across_its_narrower_side_and_a_hexagonal_prism_across_flats() {
        let deep = Footprint::of(&ObjectShape::Cuboid { half_extents_m: [0.03, 0.08, 0.05] });
        assert_eq!(deep.half_m, [0.08, 0.03]);
        assert_eq!(deep.place(PlanarPose::new(0.01, 0.0, 0.0)).phi_rad, FRAC_PI_2);
        let hexagon = Footprint::of(&hexagonal_prism());
        assert!((hexagon.half_m[1] - 0.05).abs() < 1e-5, "{hexagon:?}");
        // Its corners are at multiples of 60 degrees, so a flat's normal is half way between.
        let across_rad = hexagon.place(PlanarPose::default()).phi_rad + FRAC_PI_2;
        let off = libm::remainderf(across_rad - FRAC_PI_6, FRAC_PI_3);
        assert!(off.abs() < 1e-3, "{off}");
    }

    #[test]
    fn no_closing_finger_comes_near_the_table_however_low_the_object() {
        let mut lowest_m = f32::MAX;
        for spread_rad in [0.0, FRAC_PI_2] {
            for step in 0..200_u8 {
                let angles = HandAngles::engaged([0.01 * f32::from(step); 3], spread_rad);
                let poses = hand::link_poses(&Isometry3::identity(), &angles);
                for (link, pose) in HandLink::ALL.iter().zip(poses).filter(|(link, _)| link.finger().is_some()) {
                    let prism = hand_prism(*link);
                    let points = prism.corners_m.iter().flat_map(|[x, y]| prism.z_m.map(|z| Point3::new(*x, *y, z)));
                    let depth_m = points.fold(0.0, |depth: f32, p| depth.max((pose * p).z)) - PALM_FACE_Z_M;
                    lowest_m = lowest_m.min(PALM_OVER_TABLE_M - depth_m);
                }
            }
        }
        assert!((0.0085..0.0095).contains(&lowest_m), "{lowest_m}");
        for half_height_m in [0.01, 0.03, 0.05, 0.1, 0.15] {
            let shape = ObjectShape::Cylinder { radius_m: 0.04, half_height_m };
            let over_table_m = palm_height_m(&shape) + shape.top_height_m();
            assert!(over_table_m >= PALM_OVER_TABLE_M - 1e-6 && palm_height_m(&shape) >= PALM_HEIGHT_M);
        }
    }
}
