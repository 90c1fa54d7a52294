//! A motion of the arm: timed knots with position, velocity and acceleration, quintic between them.

mod bound;

use crate::limits::{ARM_ACCELERATION_MAX_RAD_S2, ARM_JOINTS, KNOTS_MAX, TICK_S};
use crate::robot::JointLimit;
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Instants per segment at which [`Trajectory::check`] looks, besides the knots themselves.
pub const CHECKS_PER_SEGMENT: usize = 24;
/// Longest trajectory, seconds: beyond it `f32` time is coarser than a microsecond.
pub const DURATION_MAX_S: f32 = 30.0;
/// How far a position may lie outside its limit, radians: a measured start pose stands at the limit with noise on it.
pub const POSITION_SLACK_RAD: f32 = 0.002;
/// Speed (rad/s) and acceleration (rad/s^2) that count as rest at the last knot.
const REST_MAX: f32 = 1e-3;

/// State of the arm at one instant of a trajectory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Knot {
    /// Time since the trajectory's start, seconds.
    pub t_s: f32,
    /// Joint angles, radians, URDF sign.
    pub q_rad: [f32; ARM_JOINTS],
    /// Joint velocities, rad/s.
    pub qd_rad_s: [f32; ARM_JOINTS],
    /// Joint accelerations, rad/s^2.
    pub qdd_rad_s2: [f32; ARM_JOINTS],
}

/// A motion of the arm. Between two knots every joint follows the quintic that meets both, so that position, velocity and
/// acceleration are continuous. What comes over the wire is to be [checked](Trajectory::check) before use.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Trajectory {
    /// Number of the request that this answers.
    pub request: u16,
    /// The knots in order of time; the first at 0.
    pub knots: Vec<Knot, KNOTS_MAX>,
    /// From this knot on a contact ends the motion; the number of knots or more (255): nowhere.
    pub guarded_from: u8,
}

/// Where a trajectory is at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Joint angles, radians.
    pub q_rad: [f32; ARM_JOINTS],
    /// Joint velocities, rad/s.
    pub qd_rad_s: [f32; ARM_JOINTS],
    /// Joint accelerations, rad/s^2.
    pub qdd_rad_s2: [f32; ARM_JOINTS],
}

/// Why [`Trajectory::check`] refuses; `knot` is the one at which the offending segment starts, both indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum TrajectoryError {
    /// There is no knot.
    Empty,
    /// A number is infinite or not a number.
    NotFinite {
        /// The knot that holds it.
        knot: u8,
    },
    /// The first knot is not at time 0.
    LateStart,
    /// The knot is not at least one tick after its predecessor, or is after [`DURATION_MAX_S`].
    Time {
        /// The later knot.
        knot: u8,
    },
    /// A joint leaves its range.
    Position {
        /// Start of the segment.
        knot: u8,
        /// The joint.
        joint: u8,
    },
    /// A joint is faster than its limit.
    Velocity {
        /// Start of the segment.
        knot: u8,
        /// The joint.
        joint: u8,
    },
    /// A joint accelerates more than its limit.
    Acceleration {
        /// Start of the segment.
        knot: u8,
        /// The joint.
        joint: u8,
    },
    /// A joint still moves at the last knot.
    NoRest {
        /// The joint.
        joint: u8,
    },
}

impl Trajectory {
    /// Time of the last knot, seconds; 0 without knots.
    pub fn duration(&self) -> f32 {
        self.knots.last().map_or(0.0, |knot| knot.t_s)
    }

    /// Time at which the guarded part starts, seconds; `None` if no part is guarded.
    pub fn guarded_from_s(&self) -> Option<f32> {
        let is_segment = usize::from(self.guarded_from) + 1 < self.knots.len();
        self.knots.get(usize::from(self.guarded_from)).filter(|_| is_segment).map(|knot| knot.t_s)
    }

    /// Position, velocity and acceleration at `t_s` seconds; before the start and after the end the arm rests at the first
    /// and the last knot's position. `None` without knots. Finite if the trajectory passed [`Trajectory::check`].
    pub fn sample(&self, t_s: f32) -> Option<Sample> {
        let (first, last) = (self.knots.first()?, self.knots.last()?);
        if t_s >= last.t_s {
            return Some(Sample { q_rad: last.q_rad, ..Sample::default() });
        }
        let later = self.knots.iter().position(|knot| knot.t_s > t_s).unwrap_or(0);
        match (later.checked_sub(1).and_then(|i| self.knots.get(i)), self.knots.get(later)) {
            (Some(from), Some(to)) => Some(between(from, to, t_s)),
            _ => Some(Sample { q_rad: first.q_rad, ..Sample::default() }),
        }
    }

    /// Whether the arm can follow: times, finite numbers, rest at the end, and position, velocity and acceleration within
    /// the limits, looked at in [`CHECKS_PER_SEGMENT`] instants of each segment. Accelerations are held to
    /// [`ARM_ACCELERATION_MAX_RAD_S2`]. Cost: at most `KNOTS_MAX * CHECKS_PER_SEGMENT` samples; none in segments that a bound
    /// already shows to be within the limits.
    ///
    /// # Errors
    /// The first thing found wrong, in order of time.
    pub fn check(&self, limits: &[JointLimit; ARM_JOINTS]) -> Result<(), TrajectoryError> {
        let (first, last) = self.knots.first().zip(self.knots.last()).ok_or(TrajectoryError::Empty)?;
        for (i, knot) in self.knots.iter().enumerate() {
            if !knot.is_finite() {
                return Err(TrajectoryError::NotFinite { knot: i as u8 });
            }
        }
        if first.t_s != 0.0 {
            return Err(TrajectoryError::LateStart);
        }
        check_state(&Sample::at(first), limits, 0)?;
        for (i, (from, to)) in self.knots.iter().zip(self.knots.iter().skip(1)).enumerate() {
            // Half a tick of slack: knots a tick apart in `f32` may be a rounding short of it.
            if to.t_s - from.t_s < 0.5 * TICK_S || to.t_s > DURATION_MAX_S {
                return Err(TrajectoryError::Time { knot: i as u8 + 1 });
            }
            if limits.iter().enumerate().all(|(joint, limit)| bound::keeps_within(from, to, joint, limit)) {
                continue;
            }
            for k in 1..=CHECKS_PER_SEGMENT {
                let t_s = from.t_s + (to.t_s - from.t_s) * (k as f32 / CHECKS_PER_SEGMENT as f32);
                check_state(&between(from, to, t_s), limits, i as u8)?;
            }
        }
        for joint in 0..ARM_JOINTS {
            if libm::fabsf(last.qd_rad_s[joint]) > REST_MAX || libm::fabsf(last.qdd_rad_s2[joint]) > REST_MAX {
                return Err(TrajectoryError::NoRest { joint: joint as u8 });
            }
        }
        Ok(())
    }
}

impl Knot {
    /// `true` if every component is a finite number.
    pub fn is_finite(&self) -> bool {
        let state = [self.q_rad, self.qd_rad_s, self.qdd_rad_s2];
        self.t_s.is_finite() && state.iter().flatten().all(|x| x.is_finite())
    }
}

impl Sample {
    /// The state at a knot.
    fn at(knot: &Knot) -> Self {
        Self { q_rad: knot.q_rad, qd_rad_s: knot.qd_rad_s, qdd_rad_s2: knot.qdd_rad_s2 }
    }
}

/// Comparisons are written so that a NaN, which no limit bounds, is refused too.
fn check_state(state: &Sample, limits: &[JointLimit; ARM_JOINTS], knot: u8) -> Result<(), TrajectoryError> {
    for (i, limit) in limits.iter().enumerate() {
        let joint = i as u8;
        let range = limit.lower_rad - POSITION_SLACK_RAD..=limit.upper_rad + POSITION_SLACK_RAD;
        if !range.contains(&state.q_rad[i]) {
            return Err(TrajectoryError::Position { knot, joint });
        }
        let speed = 0.0..=limit.velocity_rad_s;
        if !speed.contains(&libm::fabsf(state.qd_rad_s[i])) {
            return Err(TrajectoryError::Velocity { knot, joint });
        }
        let acceleration = 0.0..=ARM_ACCELERATION_MAX_RAD_S2[i];
        if !acceleration.contains(&libm::fabsf(state.qdd_rad_s2[i])) {
            return Err(TrajectoryError::Acceleration { knot, joint });
        }
    }
    Ok(())
}

/// The quintic that meets position, velocity and acceleration of both knots, in s = (t - t0)/T: its lower three
/// coefficients are those of `from`, the upper three solve the conditions at s = 1.
pub fn between(from: &Knot, to: &Knot, t_s: f32) -> Sample {
    let t = to.t_s - from.t_s;
    let s = (t_s - from.t_s) / t;
    let mut sample = Sample::default();
    for j in 0..ARM_JOINTS {
        let c1 = from.qd_rad_s[j] * t;
        let c2 = from.qdd_rad_s2[j] * t * t * 0.5;
        // What is left at s = 1 of position, velocity and acceleration once the lower three have done their part.
        let r0 = to.q_rad[j] - from.q_rad[j] - c1 - c2;
        let r1 = to.qd_rad_s[j] * t - c1 - 2.0 * c2;
        let r2 = to.qdd_rad_s2[j] * t * t - 2.0 * c2;
        let c3 = 10.0 * r0 - 4.0 * r1 + 0.5 * r2;
        let c4 = -15.0 * r0 + 7.0 * r1 - r2;
        let c5 = 6.0 * r0 - 3.0 * r1 + 0.5 * r2;
        sample.q_rad[j] = from.q_rad[j] + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
        sample.qd_rad_s[j] = (c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5))))) / t;
        sample.qdd_rad_s2[j] = (2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * (20.0 * c5)))) / (t * t);
    }
    sample
}

#[cfg(test)]
mod tests;
