//! Closed-form inverse kinematics of the arm (Singh and Claassens 2010; facts 4.3).
//!
//! Seven joints and six wishes leave one freedom: the **swivel**, the angle of the elbow about the line from shoulder
//! centre to wrist centre. 0 = elbow straight above that line; positive turns it anticlockwise seen along the line from
//! the wrist towards the shoulder. (Should the line be vertical, 0 = elbow towards the base's +x.)

use super::arm::{MOUNT, link_poses_from, world_from_base};
use super::tables::{ARM_LIMITS, ELBOW_OFFSET_M, FLANGE_M, FOREARM_M, SHOULDER_HEIGHT_M, UPPER_ARM_M};
use crate::limits::ARM_JOINTS;
use core::f32::consts::{PI, TAU};
use heapless::Vec;
use nalgebra::{Isometry3, Matrix3, Vector3};

/// Most solutions of one call: elbow in or out, shoulder and wrist each two ways, J5 once or twice around.
pub const SOLUTIONS_MAX: usize = 16;

/// Sines below this leave a direction undefined.
const TINY: f32 = 1e-6;

/// Why a pose has no solution at the given swivel angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unreachable {
    /// The pose or the swivel angle is not a finite number.
    NotFinite,
    /// The wrist centre is farther from the shoulder than the stretched arm reaches.
    TooFar {
        /// Shoulder to wrist centre, metres.
        distance_m: f32,
        /// Most that the arm reaches, metres.
        limit_m: f32,
    },
    /// The wrist centre is nearer to the shoulder than the elbow's limit allows.
    TooNear {
        /// Shoulder to wrist centre, metres.
        distance_m: f32,
        /// Least that the arm reaches, metres.
        limit_m: f32,
    },
    /// Every branch breaks a joint limit at this swivel angle; another one may help.
    JointLimits {
        /// Of the branch that comes nearest, the joint that is farthest outside, 0..7.
        joint: u8,
        /// By how much, radians.
        excess_rad: f32,
    },
}

/// The two links as the elbow sees them: lengths between the axes of shoulder, elbow and wrist, and how far each
/// leans from its link's own axis because of the elbow's offset.
struct Elbow {
    upper_m: f32,
    fore_m: f32,
    upper_lean_rad: f32,
    fore_lean_rad: f32,
}

impl Elbow {
    fn new() -> Self {
        Self {
            upper_m: libm::hypotf(UPPER_ARM_M, ELBOW_OFFSET_M),
            fore_m: libm::hypotf(FOREARM_M, ELBOW_OFFSET_M),
            upper_lean_rad: libm::atan2f(ELBOW_OFFSET_M, UPPER_ARM_M),
            fore_lean_rad: libm::atan2f(ELBOW_OFFSET_M, FOREARM_M),
        }
    }

    /// Shoulder to wrist with the elbow fully bent, metres.
    fn least_m(&self) -> f32 {
        let inside = PI - ARM_LIMITS[3].upper_rad + self.upper_lean_rad + self.fore_lean_rad;
        let (u, f) = (self.upper_m, self.fore_m);
        libm::sqrtf(u * u + f * f - 2.0 * u * f * libm::cosf(inside))
    }

    /// Angles of the triangle shoulder, elbow, wrist at the shoulder and at the elbow, radians. By half angles, which stay
    /// accurate where the arm is nearly straight.
    fn triangle(&self, distance_m: f32) -> (f32, f32) {
        let s = 0.5 * (self.upper_m + self.fore_m + distance_m);
        let (u, f, d) = ((s - self.upper_m).max(0.0), (s - self.fore_m).max(0.0), (s - distance_m).max(0.0));
        let at_shoulder = 2.0 * libm::atan2f(libm::sqrtf(u * d), libm::sqrtf(s * f));
        let at_elbow = 2.0 * libm::atan2f(libm::sqrtf(u * f), libm::sqrtf(s * d));
        (at_shoulder, at_elbow)
    }
}

/// Unit vectors across the direction `w`: "up" (swivel 0) and "aside" (swivel +pi/2), right-handed with `w`.
fn across(w: &Vector3<f32>) -> (Vector3<f32>, Vector3<f32>) {
    let rejected = |axis: Vector3<f32>| axis - w * w.dot(&axis);
    let up = rejected(Vector3::z());
    let up = if up.norm() < TINY { rejected(Vector3::x()) } else { up }.normalize();
    (up, w.cross(&up))
}

/// Rotation matrix about z.
fn about_z(angle_rad: f32) -> Matrix3<f32> {
    let (s, c) = libm::sincosf(angle_rad);
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

/// Rotation matrix about y.
fn about_y(angle_rad: f32) -> Matrix3<f32> {
    let (s, c) = libm::sincosf(angle_rad);
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

/// The two ways to write `r` as Rz(a) Ry(b) Rz(c). Where sin b vanishes, a is 0 and c takes the whole turn.
fn zyz(r: &Matrix3<f32>) -> [[f32; 3]; 2] {
    let sine = libm::hypotf(r[(0, 2)], r[(1, 2)]);
    [1.0, -1.0].map(|sign: f32| {
        let a = if sine < TINY { 0.0 } else { libm::atan2f(sign * r[(1, 2)], sign * r[(0, 2)]) };
        let b = libm::atan2f(sign * sine, r[(2, 2)]);
        // From the remaining rotation, which is exact also where a is not well defined.
        let rest = (about_z(a) * about_y(b)).transpose() * r;
        [a, b, libm::atan2f(rest[(1, 0)], rest[(0, 0)])]
    })
}

/// All joint angles that bring the hand of an arm at [`MOUNT`] to `world_from_hand` with the elbow at `swivel_rad`, within the limits.
///
/// # Errors
/// Says what stands in the way; see [`Unreachable`].
pub fn solve(
    world_from_hand: &Isometry3<f32>,
    swivel_rad: f32,
) -> Result<Vec<[f32; ARM_JOINTS], SOLUTIONS_MAX>, Unreachable> {
    let hand = world_from_base(&MOUNT).inverse() * world_from_hand;
    let turn = hand.rotation.to_rotation_matrix().into_inner();
    let wrist =
        hand.translation.vector - turn * Vector3::new(0.0, 0.0, FLANGE_M) - Vector3::new(0.0, 0.0, SHOULDER_HEIGHT_M);
    let distance_m = wrist.norm();
    if !(distance_m.is_finite() && swivel_rad.is_finite() && turn.iter().all(|x| x.is_finite())) {
        return Err(Unreachable::NotFinite);
    }
    let elbow = Elbow::new();
    let (least_m, most_m) = (elbow.least_m(), elbow.upper_m + elbow.fore_m);
    if distance_m > most_m {
        return Err(Unreachable::TooFar { distance_m, limit_m: most_m });
    }
    if distance_m < least_m {
        return Err(Unreachable::TooNear { distance_m, limit_m: least_m });
    }
    let w = wrist / distance_m;
    let (up, aside) = across(&w);
    let (s, c) = libm::sincosf(swivel_rad);
    let out = up * c + aside * s;
    let (at_shoulder, at_elbow) = elbow.triangle(distance_m);
    let mut found = Found::default();
    for inward in [true, false] {
        let sign = if inward { 1.0 } else { -1.0 };
        let q4 = sign * (PI - at_elbow) + elbow.upper_lean_rad + elbow.fore_lean_rad;
        // The upper arm in the plane of `w` and `out`: turned from the line to the elbow by its lean, about the elbow's axis.
        let axis = out.cross(&w) * sign;
        let (sin, cos) = libm::sincosf(at_shoulder + sign * elbow.upper_lean_rad);
        let along = w * cos + out * sin;
        let upper = Matrix3::from_columns(&[axis.cross(&along), axis, along]);
        let rest = about_y(q4).transpose() * upper.transpose() * turn;
        for [q1, q2, q3] in zyz(&upper) {
            for [q5, q6, q7] in zyz(&rest) {
                for q5 in [q5, q5 - TAU] {
                    found.offer([q1, q2, q3, q4, q5, q6, q7]);
                }
            }
        }
    }
    found.result()
}

/// Solutions so far, and of those outside the limits the nearest.
#[derive(Default)]
struct Found {
    inside: Vec<[f32; ARM_JOINTS], SOLUTIONS_MAX>,
    nearest: Option<(u8, f32)>,
}

impl Found {
    fn offer(&mut self, q_rad: [f32; ARM_JOINTS]) {
        let mut worst = (0_u8, f32::MIN);
        for (joint, (q, limit)) in (0_u8..).zip(q_rad.iter().zip(&ARM_LIMITS)) {
            let excess_rad = -limit.margin_rad(*q);
            if excess_rad > worst.1 {
                worst = (joint, excess_rad);
            }
        }
        if worst.1 <= 0.0 {
            // Never full: `solve` offers at most SOLUTIONS_MAX.
            let _ = self.inside.push(q_rad);
        } else if self.nearest.is_none_or(|(_, excess)| worst.1 < excess) {
            self.nearest = Some(worst);
        }
    }

    fn result(self) -> Result<Vec<[f32; ARM_JOINTS], SOLUTIONS_MAX>, Unreachable> {
        match (self.inside.is_empty(), self.nearest) {
            (true, Some((joint, excess_rad))) => Err(Unreachable::JointLimits { joint, excess_rad }),
            _ => Ok(self.inside),
        }
    }
}

/// The swivel angle (radians, -pi..pi) at the joint angles `q_rad`: [`solve`] with it finds `q_rad` among its solutions.
pub fn swivel(q_rad: &[f32; ARM_JOINTS]) -> f32 {
    let poses = link_poses_from(&Isometry3::identity(), q_rad);
    let wrist = poses[5].translation.vector - poses[0].translation.vector;
    let distance_m = wrist.norm();
    let w = if distance_m < TINY { Vector3::z() } else { wrist / distance_m };
    let elbow = Elbow::new();
    let sign = if q_rad[3] >= elbow.upper_lean_rad + elbow.fore_lean_rad { 1.0 } else { -1.0 };
    let out = w.cross(&(poses[3].rotation * Vector3::z())) * sign;
    let (up, aside) = across(&w);
    libm::atan2f(out.dot(&aside), out.dot(&up))
}

#[cfg(test)]
mod tests;
