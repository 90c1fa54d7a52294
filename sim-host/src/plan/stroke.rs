//! A straight motion of the hand: postures along a Cartesian line, close enough together for a curve through them.

use super::Joints;
use super::curve::Curve;
use super::ladder::Node;
use nalgebra::Isometry3;
use tactus_common::pose::wrap_turn;
use tactus_common::robot::inverse;

/// Length of line between two rungs of a ladder, metres.
const RUNG_M: f32 = 0.04;
/// Length of line between two points of the curve, metres.
const POINT_M: f32 = 0.01;
/// Radians of turn that count as a metre of line.
const TURN_M_PER_RAD: f32 = 0.2;
/// Change of a joint between neighbouring points beyond which the line is broken, radians.
const JUMP_MAX_RAD: f32 = 0.25;

/// A straight line of hand poses; orientation turns evenly.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// First world-from-hand pose.
    pub from: Isometry3<f32>,
    /// Last world-from-hand pose.
    pub to: Isometry3<f32>,
}

impl Stroke {
    /// Length of the line, metres, a turn counted in.
    pub fn length_m(&self) -> f32 {
        (self.to.translation.vector - self.from.translation.vector).norm()
            + TURN_M_PER_RAD * self.from.rotation.angle_to(&self.to.rotation)
    }

    /// Number of rungs after the first that the stroke needs.
    pub fn rungs(&self) -> usize {
        (libm::ceilf(self.length_m() / RUNG_M) as usize).clamp(2, 40)
    }

    /// The pose at part `s` (0..1) of the line.
    pub fn pose(&self, s: f32) -> Isometry3<f32> {
        let p = self.from.translation.vector.lerp(&self.to.translation.vector, s);
        // Two opposite orientations have no middle; then stay, and the end is refused for its jump.
        let turn = self.from.rotation.try_slerp(&self.to.rotation, s, 1e-6).unwrap_or(self.from.rotation);
        Isometry3::from_parts(p.into(), turn)
    }

    /// Poses of the rungs after the first.
    pub fn rung_poses(&self) -> impl Iterator<Item = Isometry3<f32>> + '_ {
        let n = self.rungs();
        (1..=n).map(move |k| self.pose(k as f32 / n as f32))
    }

    /// Postures along the line through the swivel angles of `way` (one node per rung, the first included), starting with the posture `way[0]`
    /// itself. `None` if the arm would have to jump.
    pub fn postures(&self, way: &[Node]) -> Option<Vec<Joints>> {
        let first = way.first()?;
        let swivels = unwrapped_swivels(way);
        let count = (libm::ceilf(self.length_m() / POINT_M) as usize).clamp(4, 100);
        let mut postures = vec![first.q_rad];
        for k in 1..=count {
            let s = k as f32 / count as f32;
            let pose = self.pose(s);
            let before = postures[postures.len() - 1];
            let jump = |q: &Joints| q.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let solutions = inverse::solve(&pose, wrap_turn(smooth(&swivels, s))).ok()?;
            let next = solutions.iter().min_by(|a, b| jump(a).total_cmp(&jump(b)))?;
            if jump(next) > JUMP_MAX_RAD {
                return None;
            }
            postures.push(*next);
        }
        Some(postures)
    }

    /// The curve through postures along this line; its parameter is metres of line.
    pub fn curve(&self, postures: &[Joints]) -> Option<Curve> {
        Curve::through(postures, f64::from(self.length_m()) / (postures.len().checked_sub(1)? as f64))
    }
}

/// Swivel angles without jumps of a whole turn.
fn unwrapped_swivels(way: &[Node]) -> Vec<f32> {
    let mut swivels: Vec<f32> = Vec::with_capacity(way.len());
    for node in way {
        let last = swivels.last().copied().unwrap_or(node.swivel_rad);
        swivels.push(last + wrap_turn(node.swivel_rad - last));
    }
    swivels
}

/// Value at part `s` of a cubic B-spline over evenly spaced control values: smooth, and it starts and ends on the first and the last.
fn smooth(values: &[f32], s: f32) -> f32 {
    let Some(last) = values.len().checked_sub(1).filter(|n| *n > 0) else {
        return values.first().copied().unwrap_or(0.0);
    };
    let x = s.clamp(0.0, 1.0) * last as f32;
    let i = (x as usize).min(last - 1);
    let control = |k: isize| match usize::try_from(k) {
        Err(_) => 2.0 * values[0] - values[1],
        Ok(k) if k > last => 2.0 * values[last] - values[last - 1],
        Ok(k) => values[k],
    };
    let (t, k) = (x - i as f32, i as isize);
    let r = 1.0 - t;
    let weights = [r * r * r, 4.0 + t * t * (3.0 * t - 6.0), 4.0 + r * r * (3.0 * r - 6.0), t * t * t];
    weights.iter().enumerate().map(|(m, w)| w / 6.0 * control(k - 1 + m as isize)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_swivel_profile_keeps_ends_and_straight_parts() {
        assert!((smooth(&[1.0, 2.0, 4.0], 0.0) - 1.0).abs() < 1e-6);
        assert!((smooth(&[1.0, 2.0, 4.0], 1.0) - 4.0).abs() < 1e-6);
        for k in 0..=10 {
            let s = k as f32 / 10.0;
            assert!((smooth(&[1.0, 2.0, 3.0, 4.0], s) - 1.0 - 3.0 * s).abs() < 1e-5);
        }
        assert_eq!(smooth(&[0.7], 0.5), 0.7);
    }
}
