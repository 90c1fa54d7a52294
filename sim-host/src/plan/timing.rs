//! From a path to a timed trajectory: a smooth start, a steady run, a smooth stop, as fast as the limits allow.

use super::curve::{Curve, Point};
use tactus_common::limits::{ARM_ACCELERATION_MAX_RAD_S2, KNOTS_MAX};
use tactus_common::robot::ARM_LIMITS;
use tactus_common::trajectory::Knot;

/// Shortest motion, seconds: room for a few knots at least a tick apart.
const DURATION_MIN_S: f64 = 0.06;

/// How fast a curve may be followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Most units of the curve's parameter per second.
    pub speed_max: f64,
    /// Part of the joints' velocity limits to use, 0..1.
    pub velocity_scale: f64,
    /// Part of the joints' acceleration limits to use, 0..1.
    pub acceleration_scale: f64,
    /// How far the quintics between the knots may stray from the curve, radians.
    pub tolerance_rad: f64,
}

/// The curve's parameter over time: speed rises along 3 s^2 - 2 s^3, stays, and falls alike. Acceleration is continuous and zero at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Law {
    speed: f64,
    ramp_s: f64,
    cruise_s: f64,
}

impl Law {
    /// Time of the whole motion, seconds.
    fn duration(&self) -> f64 {
        2.0 * self.ramp_s + self.cruise_s
    }

    /// Parameter, its speed and its acceleration at time `t_s`.
    fn at(&self, t_s: f64) -> [f64; 3] {
        let rise = |t: f64| {
            let s = t / self.ramp_s;
            [
                self.speed * self.ramp_s * s * s * s * (1.0 - 0.5 * s),
                self.speed * s * s * (3.0 - 2.0 * s),
                self.speed / self.ramp_s * 6.0 * s * (1.0 - s),
            ]
        };
        if t_s < self.ramp_s {
            rise(t_s)
        } else if t_s <= self.ramp_s + self.cruise_s {
            [self.speed * (0.5 * self.ramp_s + t_s - self.ramp_s), self.speed, 0.0]
        } else {
            let [u, du, ddu] = rise((self.duration() - t_s).max(0.0));
            [self.speed * (self.ramp_s + self.cruise_s) - u, du, -ddu]
        }
    }

    /// The same motion in `factor` times the time.
    fn stretched(&self, factor: f64) -> Self {
        Self { speed: self.speed / factor, ramp_s: self.ramp_s * factor, cruise_s: self.cruise_s * factor }
    }

    /// The fastest motion along `curve` within `pace`.
    fn fastest(curve: &Curve, pace: &Pace) -> Self {
        let (mut per_velocity, mut per_acceleration, mut bend) = (0.0_f64, 1e-9_f64, 0.0_f64);
        let samples = 4 * curve.pieces();
        for k in 0..=samples {
            let point = curve.at(curve.length() * k as f64 / samples as f64);
            for j in 0..7 {
                let acceleration = pace.acceleration_scale * f64::from(ARM_ACCELERATION_MAX_RAD_S2[j]);
                per_velocity = per_velocity
                    .max(point.dq[j].abs() / (pace.velocity_scale * f64::from(ARM_LIMITS[j].velocity_rad_s)));
                per_acceleration = per_acceleration.max(point.dq[j].abs() / acceleration);
                bend = bend.max(point.ddq[j].abs() / acceleration);
            }
        }
        let length = curve.length();
        let mut speed = pace.speed_max.min(1.0 / per_velocity.max(1e-9)).min(1.0 / libm::sqrt(bend.max(1e-12)));
        // Peak acceleration of a ramp is 1.5 speed / ramp_s; without a cruise the whole length is speed * ramp_s.
        speed = speed.min(libm::sqrt(length / (1.5 * per_acceleration)));
        let ramp_s = 1.5 * speed * per_acceleration;
        let law = Self { speed, ramp_s, cruise_s: (length / speed - ramp_s).max(0.0) };
        // The bounds above ignore that bend and ramp add up, or that they fall on different places: settle by uniform stretching.
        let law = law.stretched(law.excess(curve, pace));
        law.stretched((DURATION_MIN_S / law.duration()).max(1.0))
    }

    /// By what factor time must be stretched (or may be shrunk, below 1) so that one limit is just met.
    fn excess(&self, curve: &Curve, pace: &Pace) -> f64 {
        let mut factor = self.speed / pace.speed_max;
        let samples = 6 * curve.pieces() + 60;
        for k in 0..=samples {
            let state = joint_state(curve, self, self.duration() * k as f64 / samples as f64);
            for j in 0..7 {
                let velocity = pace.velocity_scale * f64::from(ARM_LIMITS[j].velocity_rad_s);
                let acceleration = pace.acceleration_scale * f64::from(ARM_ACCELERATION_MAX_RAD_S2[j]);
                factor = factor.max(state.dq[j].abs() / velocity).max(libm::sqrt(state.ddq[j].abs() / acceleration));
            }
        }
        factor
    }
}

/// Joint angles, velocities and accelerations at time `t_s`.
fn joint_state(curve: &Curve, law: &Law, t_s: f64) -> Point {
    let [u, du, ddu] = law.at(t_s);
    let p = curve.at(u);
    Point { q: p.q, dq: p.dq.map(|d| d * du), ddq: core::array::from_fn(|j| p.ddq[j] * du * du + p.dq[j] * ddu) }
}

/// Knots of the fastest motion from rest to rest along `curve`, times from 0: as few per phase as keep the quintics between them within
/// `tolerance_rad` of the curve. `None` if [`KNOTS_MAX`] do not suffice.
pub fn knots_along(curve: &Curve, pace: &Pace) -> Option<Vec<Knot>> {
    let law = Law::fastest(curve, pace);
    for pieces in [1, 2, 3, 4, 5, 6, 8, 10, 12, 15] {
        let times = knot_times(&law, pieces);
        if times.len() > KNOTS_MAX {
            return None;
        }
        let knots: Vec<Knot> = times.iter().map(|t| knot(curve, &law, *t)).collect();
        if deviation(curve, &law, &knots) <= pace.tolerance_rad {
            return Some(knots);
        }
    }
    None
}

/// Ends of the phases, each phase split into `pieces`, the run into more if it takes long.
fn knot_times(law: &Law, pieces: usize) -> Vec<f64> {
    let mut times = vec![0.0];
    for phase in [law.ramp_s, law.cruise_s, law.ramp_s] {
        // A phase shorter than a few ticks would put knots closer together than they may be.
        if phase < 0.01 {
            continue;
        }
        let start = times[times.len() - 1];
        let count = if pieces == 1 { 1 } else { ((phase / law.ramp_s.min(phase)) as usize).clamp(1, 3) * pieces };
        let count = count.min((phase / 0.01) as usize).max(1);
        times.extend((1..=count).map(|k| start + phase * k as f64 / count as f64));
    }
    if let Some(last) = times.last_mut() {
        *last = law.duration();
    }
    times
}

/// The state of the motion as a knot; at the ends exactly at rest.
fn knot(curve: &Curve, law: &Law, t_s: f64) -> Knot {
    let state = joint_state(curve, law, t_s);
    let moving = if t_s > 0.0 && t_s < law.duration() { 1.0 } else { 0.0 };
    Knot {
        t_s: t_s as f32,
        q_rad: state.q.map(|x| x as f32),
        qd_rad_s: state.dq.map(|x| (moving * x) as f32),
        qdd_rad_s2: state.ddq.map(|x| (moving * x) as f32),
    }
}

/// Largest distance in any joint between the curve at a given time and the quintics, at the middles and quarters of all segments.
fn deviation(curve: &Curve, law: &Law, knots: &[Knot]) -> f64 {
    let mut worst = 0.0_f64;
    for (from, to) in knots.iter().zip(knots.iter().skip(1)) {
        for s in [0.25, 0.5, 0.75] {
            let t_s = from.t_s + s * (to.t_s - from.t_s);
            let q = tactus_common::trajectory::between(from, to, t_s).q_rad;
            let wanted = joint_state(curve, law, f64::from(t_s)).q;
            for j in 0..7 {
                worst = worst.max((f64::from(q[j]) - wanted[j]).abs());
            }
        }
    }
    worst
}
