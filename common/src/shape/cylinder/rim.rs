//! Axes at a right angle to an edge of the prism and to a rim of the cylinder.
//!
//! Seen along the edge, the edge is a point and the rim an ellipse. With `u` level and `w` upwards, both at a right
//! angle to the edge, the point `(x, y)` about the ellipse's centre and `k`, `c` the edge's vertical and horizontal parts,
//! the ellipse has the half axes `r` and `k r`, and the axis `(1, t) / sqrt(1 + t^2)` is a critical one where
//! `y - x t + r c^2 t / sqrt(1 + k^2 t^2) = 0`. By symmetry `x >= 0` and `t > 0`; there the left side is concave, so
//! it has two roots at most, the larger one is the maximum of the separation, and Newton's method comes down on it
//! from above without ever passing it.

use super::Cylinder;
use crate::shape::axis::{AxisKind, Best, Body, PARALLEL_SINE_SQ};
use crate::shape::placed::Placed;
use nalgebra::Vector3;

/// Steps of Newton's method: five bring it to within rounding from far away.
const STEPS_MAX: usize = 8;
/// Change of `t`, relative, below which it stays.
const CONVERGED: f32 = 1e-6;
/// Least `x` (metres) and `k`: nearer to 0 the axis is the vertical itself to within rounding.
const X_MIN_M: f32 = 1e-7;
const K_MIN: f32 = 1e-6;

/// Directions at a right angle to an edge.
struct Across {
    /// Level.
    u: Vector3<f32>,
    /// Upwards.
    w: Vector3<f32>,
    /// The edge's horizontal and vertical parts.
    c: f32,
    k: f32,
}

impl Across {
    /// `None` for an edge that is nearly upright: seen along it the rim is a circle, and axes of it are level.
    fn new(edge: &Vector3<f32>) -> Option<Self> {
        let c_sq = edge.x * edge.x + edge.y * edge.y;
        if c_sq < PARALLEL_SINE_SQ {
            return None;
        }
        let c = libm::sqrtf(c_sq);
        let (ux, uy) = (edge.x / c, edge.y / c);
        let u = Vector3::new(uy, -ux, 0.0);
        Some(Self { u, w: Vector3::new(-ux * edge.z, -uy * edge.z, c), c, k: libm::fabsf(edge.z) })
    }

    /// Unit axes at a right angle to the edge through `p` and to the upper and the lower rim, where there are any and the
    /// bodies may be farther apart along them than `best_m`, for those that `may_support` leaves: given the level and the
    /// upright direction between which an axis lies.
    fn axes(
        &self,
        body: &Cylinder,
        p: &Vector3<f32>,
        best_m: f32,
        may_support: impl Fn(&Vector3<f32>, &Vector3<f32>) -> bool,
    ) -> [Option<Vector3<f32>>; 2] {
        let x = p.dot(&self.u);
        let (x, u) = if x < 0.0 { (-x, -self.u) } else { (x, self.u) };
        [self.w, -self.w].map(|w| {
            let y = p.dot(&w) - body.half_height_m * self.c;
            let beside = x - body.radius_m;
            // The separation from the rim's outermost point alone: no axis between the two directions does better.
            let no_better = if beside > 0.0 && y > 0.0 {
                best_m > 0.0 && beside * beside + y * y <= best_m * best_m
            } else {
                beside <= best_m && y <= best_m
            };
            if no_better || !may_support(&u, &w) {
                return None;
            }
            let t = self.root(body.radius_m, x.max(X_MIN_M), y)?;
            Some((u + w * t) / libm::sqrtf(1.0 + t * t))
        })
    }

    /// The larger root `t > 0`, if there is one.
    fn root(&self, radius_m: f32, x: f32, y: f32) -> Option<f32> {
        let (a, k) = (radius_m * self.c * self.c, self.k.max(K_MIN));
        // Two bounds from above: the fraction is at most 1 / k, and at most t.
        let mut t = (y + a / k) / x;
        if x > a {
            t = t.min(y / (x - a));
        }
        for _ in 0..STEPS_MAX {
            let s = 1.0 / libm::sqrtf(1.0 + k * k * t * t);
            let (value, slope) = (y - x * t + a * t * s, a * s * s * s - x);
            // Left of the top: there is no root.
            if !(t > 0.0 && slope < 0.0) {
                return None;
            }
            let step = value / slope;
            t -= step;
            if libm::fabsf(step) <= CONVERGED * t {
                break;
            }
        }
        (t > 0.0).then_some(t)
    }
}

/// Offers the axes of all edges of the prism that have the edge as their support.
pub(super) fn offer(body: &Cylinder, placed: &Placed, best: &mut Best) {
    let up = placed.axes[2];
    let mut before = placed.sides().map(|(side, _)| side.along).last().unwrap_or(up);
    let upright = Across::new(&up);
    for (side, corner) in placed.sides() {
        if let Some(across) = Across::new(&side.along) {
            // The edge of the upper polygon is the lowest where the axis falls along the prism, that of the lower one where
            // it rises, and neither where the axis does not point into the side.
            for (z_m, rises) in [(placed.prism.z_m[0], true), (placed.prism.z_m[1], false)] {
                let p = corner + up * z_m;
                let supports = |u: &Vector3<f32>, w: &Vector3<f32>| {
                    (u.dot(&side.outward) < 0.0 || w.dot(&side.outward) < 0.0)
                        && ((u.dot(&up) > 0.0) == rises || (w.dot(&up) > 0.0) == rises)
                };
                for normal in across.axes(body, &p, best.distance_m, supports).into_iter().flatten() {
                    let along = normal.dot(&up);
                    if normal.dot(&side.outward) < 0.0 && (along > 0.0) == rises {
                        best.offer(normal.dot(&p) - body.reach_m(&normal), normal, AxisKind::Object);
                    }
                }
            }
        }
        if let Some(across) = &upright {
            // The corner's edge along the prism is the lowest where both sides rise from it.
            let rise = |u: &Vector3<f32>, w: &Vector3<f32>| {
                (u.dot(&side.along) > 0.0 || w.dot(&side.along) > 0.0) && (u.dot(&before) < 0.0 || w.dot(&before) < 0.0)
            };
            for normal in across.axes(body, corner, best.distance_m, rise).into_iter().flatten() {
                if normal.dot(&side.along) > 0.0 && normal.dot(&before) < 0.0 {
                    best.offer(normal.dot(corner) - body.reach_m(&normal), normal, AxisKind::Object);
                }
            }
        }
        before = side.along;
    }
}
