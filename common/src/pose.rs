//! The planar pose of an object that stands on a table, and what is known about it.

use core::f32::consts::{PI, TAU};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Pose of an object that stands upright on the table, in the world frame (z up, origin on the table top's centre).
///
/// The height of the frame above the table is the shape's own matter (its rest height), so it is not stored here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct PlanarPose {
    /// World x of the object frame's origin, metres.
    pub x_m: f32,
    /// World y of the object frame's origin, metres.
    pub y_m: f32,
    /// Rotation about the world's z axis, radians, positive anticlockwise seen from above.
    pub phi_rad: f32,
}

impl PlanarPose {
    /// A pose from its components (metres, metres, radians).
    pub const fn new(x_m: f32, y_m: f32, phi_rad: f32) -> Self {
        Self { x_m, y_m, phi_rad }
    }

    /// `true` if every component is a finite number.
    pub fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.phi_rad.is_finite()
    }

    /// The components as an array `[x, y, phi]`.
    pub fn to_array(self) -> [f32; 3] {
        [self.x_m, self.y_m, self.phi_rad]
    }

    /// The pose with components `[x, y, phi]`.
    pub fn from_array(a: [f32; 3]) -> Self {
        Self::new(a[0], a[1], a[2])
    }

    /// World-from-object transform, the object's origin at height `z_m` above the table top.
    pub fn isometry(&self, z_m: f32) -> Isometry3<f32> {
        Isometry3::from_parts(
            Translation3::new(self.x_m, self.y_m, z_m),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.phi_rad),
        )
    }

    /// Distance to `other` in the plane, metres.
    pub fn distance_m(&self, other: &Self) -> f32 {
        libm::hypotf(self.x_m - other.x_m, self.y_m - other.y_m)
    }

    /// Yaw from `other` to here, radians in (-symmetry/2, symmetry/2], for an object that looks the same after a turn by
    /// `symmetry_rad`; 0 if that is 0: every turn leaves it alike.
    pub fn turn_from_rad(&self, other: &Self, symmetry_rad: f32) -> f32 {
        if symmetry_rad > 0.0 { wrap(self.phi_rad - other.phi_rad, symmetry_rad) } else { 0.0 }
    }

    /// The pose of the world in this object's frame.
    pub fn inverse(&self) -> PlanarPose {
        let (s, c) = libm::sincosf(self.phi_rad);
        PlanarPose::new(-c * self.x_m - s * self.y_m, s * self.x_m - c * self.y_m, -self.phi_rad)
    }

    /// `self * local`: a planar pose given in this object's frame, expressed in the world.
    pub fn compose(&self, local: &PlanarPose) -> PlanarPose {
        let (s, c) = libm::sincosf(self.phi_rad);
        PlanarPose::new(
            self.x_m + c * local.x_m - s * local.y_m,
            self.y_m + s * local.x_m + c * local.y_m,
            self.phi_rad + local.phi_rad,
        )
    }
}

/// What is known about the error of a guess: the true pose lies within `guess +- half width`, per component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Interval {
    /// Half width in x, metres; 0 = known exactly.
    pub x_m: f32,
    /// Half width in y, metres; 0 = known exactly.
    pub y_m: f32,
    /// Half width in phi, radians; 0 = known exactly.
    pub phi_rad: f32,
}

impl Interval {
    /// The same for the first `dof` components of (x, y, phi); the others are known exactly.
    pub fn of_first(self, dof: u8) -> Self {
        let [x_m, y_m, phi_rad] = self.to_array();
        let unknown = |component: u8, half_width| if component < dof { half_width } else { 0.0 };
        Self { x_m: unknown(0, x_m), y_m: unknown(1, y_m), phi_rad: unknown(2, phi_rad) }
    }

    /// Components that are not known exactly.
    pub fn dof(&self) -> usize {
        self.to_array().iter().filter(|half_width| **half_width > 0.0).count()
    }

    /// The half widths as an array `[x, y, phi]`.
    pub fn to_array(self) -> [f32; 3] {
        [self.x_m, self.y_m, self.phi_rad]
    }
}

/// `angle_rad` brought into (-period/2, period/2].
///
/// With `period_rad` the symmetry of an object (pi for a box), two angles that the object cannot tell apart
/// differ by zero.
pub fn wrap(angle_rad: f32, period_rad: f32) -> f32 {
    let turns = libm::floorf(angle_rad / period_rad + 0.5);
    angle_rad - turns * period_rad
}

/// `angle_rad` brought into [-pi, pi).
pub fn wrap_turn(angle_rad: f32) -> f32 {
    wrap(angle_rad, TAU)
}

/// The yaw symmetry of an object with two equal ends, radians.
pub const HALF_TURN_RAD: f32 = PI;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrapped_angle_differs_by_whole_periods_and_is_smallest() {
        for k in -3..=3 {
            for a in [-1.5_f32, -0.3, 0.0, 0.7, 1.5] {
                let w = wrap(a + k as f32 * PI, PI);
                assert!((w - a).abs() < 1e-5, "{a} + {k} pi -> {w}");
            }
        }
    }

    #[test]
    fn poses_differ_by_a_distance_and_by_the_turn_that_can_be_seen() {
        let (a, b) = (PlanarPose::new(0.03, 0.0, 3.0), PlanarPose::new(0.0, 0.04, 0.0));
        assert!((a.distance_m(&b) - 0.05).abs() < 1e-7);
        assert!((a.turn_from_rad(&b, HALF_TURN_RAD) - (3.0 - PI)).abs() < 1e-6);
        assert!((b.turn_from_rad(&a, TAU) + 3.0).abs() < 1e-6);
        assert_eq!(a.turn_from_rad(&b, 0.0), 0.0, "a round object has no yaw");
    }

    #[test]
    fn of_an_interval_the_first_components_stay_unknown() {
        let whole = Interval { x_m: 0.1, y_m: 0.2, phi_rad: 0.3 };
        assert_eq!([1, 2, 3].map(|dof| whole.of_first(dof).dof()), [1, 2, 3]);
        assert_eq!(whole.of_first(2), Interval { phi_rad: 0.0, ..whole });
    }

    #[test]
    fn a_pose_composed_with_its_inverse_is_the_world_itself() {
        for pose in [PlanarPose::new(0.2, -0.1, 0.4), PlanarPose::new(-3.0, 2.0, -2.5), PlanarPose::default()] {
            for nothing in [pose.compose(&pose.inverse()), pose.inverse().compose(&pose)] {
                assert!(nothing.to_array().iter().all(|v| v.abs() < 1e-6), "{nothing:?}");
            }
        }
    }

    #[test]
    fn composing_agrees_with_the_isometries() {
        let a = PlanarPose::new(0.2, -0.1, 0.4);
        let b = PlanarPose::new(-0.03, 0.05, 1.1);
        let by_isometry = a.isometry(0.0) * b.isometry(0.0);
        let c = a.compose(&b);
        assert!((by_isometry.translation.vector - c.isometry(0.0).translation.vector).norm() < 1e-6);
        assert!(by_isometry.rotation.angle_to(&c.isometry(0.0).rotation) < 1e-5);
    }
}
