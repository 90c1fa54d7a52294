//! Plays a trajectory: forwards, to a guarded stop, or back the way it came.
//!
//! The trajectory is walked by a path time that may run slower than the clock or backwards. Its rate changes at
//! a bounded slope, so the reference stays continuous in position and velocity whatever happens, and continuous
//! in acceleration as long as nothing stops it.

use tactus_common::limits::{ARM_ACCELERATION_MAX_RAD_S2, ARM_JOINTS, TICK_S};
use tactus_common::robot::ARM_LIMITS;
use tactus_common::trajectory::{Sample, Trajectory, TrajectoryError};

/// Slope of the path rate, 1/s: full stop from rate 1 in 20 ms, so 0.6 mm at a descent of 0.06 m/s.
const RATE_SLOPE: f32 = 50.0;
/// Slope of the path rate when nothing is urgent, 1/s.
const RATE_SLOPE_GENTLE: f32 = 5.0;
/// Slope of the path rate of a stop with a load that is hardly held, 1/s: 1.5 m/s^2 from 0.15 m/s.
const RATE_SLOPE_LOADED: f32 = 10.0;
/// Instants of the way back at which its rate is checked against the joints' limits.
const RETURN_CHECKS: u8 = 32;
/// Share of the limits that the way back uses.
const RETURN_MARGIN: f32 = 0.85;
/// A trajectory may start at most this far from the reference that is held, radians.
const START_TOLERANCE_RAD: f32 = 5e-3;
/// Speed (rad/s) and acceleration (rad/s^2) that count as rest.
const REST_MAX: f32 = 1e-3;

/// The arm standing still at `q_rad`.
pub fn still(q_rad: [f32; ARM_JOINTS]) -> Sample {
    Sample { q_rad, ..Sample::default() }
}

/// Why a trajectory was not loaded. What was held before is still held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadError {
    /// The arm is moving; stop it first.
    Busy,
    /// Joint `joint` of the first knot is not where the arm is held.
    StartMismatch {
        /// Joint index, 0 = J1.
        joint: u8,
    },
    /// The trajectory itself is not sound.
    Unsound(TrajectoryError),
    /// It does not rest where the arm stands still: at knot `knot`, the first or the one where the guarded part begins.
    NoRest {
        /// Knot index.
        knot: u8,
    },
}

/// What the executor is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Stands at the end, the start or wherever it was stopped.
    Holding,
    /// Moves forwards, before the guarded part.
    Travelling,
    /// Stands at the beginning of the guarded part and waits for [`Executor::enter_guarded`].
    AtGuard,
    /// Moves forwards in the guarded part.
    Guarded,
    /// Is being stopped.
    Stopping,
    /// Is being stopped with a load that is hardly held.
    Pausing,
    /// Moves back to the beginning of the guarded part.
    Returning,
}

/// The trajectory executor. One trajectory at a time, in place.
#[derive(Clone, Debug)]
pub struct Executor {
    trajectory: Trajectory,
    guard_s: f32,
    path_s: f32,
    rate: f32,
    return_rate: f32,
    /// Path time to which the way back leads.
    return_to_s: f32,
    motion: Motion,
    reference: Sample,
}

impl Default for Executor {
    /// An executor that holds all joints at 0.
    fn default() -> Self {
        Self::holding([0.0; ARM_JOINTS])
    }
}

impl Executor {
    /// An executor that holds `q_rad`.
    pub fn holding(q_rad: [f32; ARM_JOINTS]) -> Self {
        Self {
            trajectory: Trajectory::default(),
            guard_s: f32::INFINITY,
            path_s: 0.0,
            rate: 0.0,
            return_rate: 1.0,
            return_to_s: 0.0,
            motion: Motion::Holding,
            reference: still(q_rad),
        }
    }

    /// What it is doing.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// Has it reached the trajectory's end?
    pub fn at_end(&self) -> bool {
        self.motion == Motion::Holding && self.path_s >= self.trajectory.duration()
    }

    /// The present reference.
    pub fn reference(&self) -> &Sample {
        &self.reference
    }

    /// Forgets any trajectory and holds `q_rad`.
    pub fn hold(&mut self, q_rad: [f32; ARM_JOINTS]) {
        self.trajectory.knots.clear();
        self.guard_s = f32::INFINITY;
        self.path_s = 0.0;
        self.motion = Motion::Holding;
        self.rate = 0.0;
        self.reference = still(q_rad);
    }

    /// Takes a trajectory and starts it.
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn load(&mut self, trajectory: &Trajectory) -> Result<(), LoadError> {
        if self.motion != Motion::Holding {
            return Err(LoadError::Busy);
        }
        trajectory.check(&ARM_LIMITS).map_err(LoadError::Unsound)?;
        check_rests(trajectory)?;
        let first = trajectory.sample(0.0).ok_or(LoadError::Unsound(TrajectoryError::Empty))?;
        for joint in 0..ARM_JOINTS {
            if (first.q_rad[joint] - self.reference.q_rad[joint]).abs() > START_TOLERANCE_RAD {
                return Err(LoadError::StartMismatch { joint: joint as u8 });
            }
        }
        self.trajectory.request = trajectory.request;
        self.trajectory.guarded_from = trajectory.guarded_from;
        // Knot by knot into place: the whole would pass over the stack.
        self.trajectory.knots.clear();
        let _ = self.trajectory.knots.extend_from_slice(&trajectory.knots);
        self.guard_s = trajectory.guarded_from_s().unwrap_or(f32::INFINITY);
        self.path_s = 0.0;
        self.rate = 1.0;
        self.motion = Motion::Travelling;
        Ok(())
    }

    /// Lets the motion go on into the guarded part.
    pub fn enter_guarded(&mut self) {
        if self.motion == Motion::AtGuard {
            self.motion = Motion::Guarded;
            self.rate = 1.0;
        }
    }

    /// Stops within 20 ms (from a way back at rate 3: within 60 ms). The way back from there leads to the beginning of
    /// the guarded part, or of the trajectory if that was not reached.
    pub fn stop(&mut self) {
        if !matches!(self.motion, Motion::Holding | Motion::AtGuard) {
            self.motion = Motion::Stopping;
        }
    }

    /// Stops gently, in 0.1 s, with a load that is hardly held; [`Self::go_on`] may follow.
    pub fn pause(&mut self) {
        if matches!(self.motion, Motion::Travelling | Motion::Guarded) {
            self.motion = Motion::Pausing;
        }
    }

    /// Goes on from where the motion was stopped on its way forwards.
    pub fn go_on(&mut self) {
        if self.motion == Motion::Holding && self.path_s < self.trajectory.duration() {
            self.motion = if self.path_s < self.guard_s { Motion::Travelling } else { Motion::Guarded };
        }
    }

    /// Goes back to the beginning of the guarded part (or of the trajectory), `rate` times as fast as it came, or as
    /// fast as the joints may.
    pub fn go_back(&mut self, rate: f32) {
        if self.motion == Motion::Holding {
            self.motion = Motion::Returning;
            self.return_to_s = if self.path_s < self.guard_s { 0.0 } else { self.guard_s };
            self.return_rate = rate.min(self.rate_max());
        }
    }

    /// Largest rate at which the way back keeps to the joints' limits.
    fn rate_max(&self) -> f32 {
        let start_s = self.return_to_s;
        let span_s = self.path_s - start_s;
        let mut rate_max = f32::INFINITY;
        for i in 0..=RETURN_CHECKS {
            let share = i as f32 / RETURN_CHECKS as f32;
            let Some(sample) = self.trajectory.sample(start_s + share * span_s) else { return 1.0 };
            for (j, limit) in ARM_LIMITS.iter().enumerate() {
                let speed = limit.velocity_rad_s / sample.qd_rad_s[j].abs().max(1e-6);
                let acceleration = ARM_ACCELERATION_MAX_RAD_S2[j] / sample.qdd_rad_s2[j].abs().max(1e-6);
                rate_max = rate_max.min(RETURN_MARGIN * speed.min(libm::sqrtf(acceleration)));
            }
        }
        rate_max.max(1.0)
    }

    /// The next reference, one tick on.
    pub fn tick(&mut self) -> Sample {
        let target = match self.motion {
            Motion::Holding | Motion::AtGuard | Motion::Stopping | Motion::Pausing => 0.0,
            Motion::Travelling | Motion::Guarded => 1.0,
            Motion::Returning => -self.return_rate,
        };
        if matches!(self.motion, Motion::Holding | Motion::AtGuard) {
            self.rate = 0.0;
            self.reference = still(self.reference.q_rad);
            return self.reference;
        }
        let slope = match self.motion {
            Motion::Stopping => RATE_SLOPE,
            Motion::Pausing => RATE_SLOPE_LOADED,
            Motion::Holding | Motion::AtGuard | Motion::Travelling | Motion::Guarded | Motion::Returning => {
                RATE_SLOPE_GENTLE
            }
        };
        let rate_before = self.rate;
        let most = slope * TICK_S;
        // Not `clamp`: it panics for bounds the wrong way round, with a message that brings the formatting of floats along.
        let change = (target - self.rate).max(-most).min(most);
        self.rate += change;
        self.path_s += self.rate * TICK_S;
        let rate_dot = (self.rate - rate_before) / TICK_S;
        self.arrive();
        let sample = self.trajectory.sample(self.path_s).unwrap_or(self.reference);
        let moving = !matches!(self.motion, Motion::Holding | Motion::AtGuard);
        self.reference = still(sample.q_rad);
        if moving {
            for j in 0..ARM_JOINTS {
                self.reference.qd_rad_s[j] = sample.qd_rad_s[j] * self.rate;
                self.reference.qdd_rad_s2[j] =
                    sample.qdd_rad_s2[j] * self.rate * self.rate + sample.qd_rad_s[j] * rate_dot;
            }
        } else {
            self.rate = 0.0;
        }
        self.reference
    }

    /// Ends the motion where its path ends; the next one begins from rate 0.
    fn arrive(&mut self) {
        let end_s = self.trajectory.duration();
        match self.motion {
            Motion::Travelling if self.path_s >= self.guard_s && self.guard_s < end_s => {
                self.path_s = self.guard_s;
                self.motion = Motion::AtGuard;
            }
            Motion::Travelling | Motion::Guarded if self.path_s >= end_s => {
                self.path_s = end_s;
                self.motion = Motion::Holding;
            }
            // The rate reaches 0 exactly, from either side: its last step is cut to what is left.
            Motion::Stopping | Motion::Pausing if self.rate == 0.0 => self.motion = Motion::Holding,
            Motion::Returning if self.path_s <= self.return_to_s => {
                self.path_s = self.return_to_s;
                self.motion = Motion::Holding;
            }
            Motion::Holding
            | Motion::AtGuard
            | Motion::Travelling
            | Motion::Guarded
            | Motion::Stopping
            | Motion::Pausing
            | Motion::Returning => {}
        }
    }
}

/// The reference stands still before the start and where the guarded part begins: a trajectory that moves there would
/// make it jump in velocity.
fn check_rests(trajectory: &Trajectory) -> Result<(), LoadError> {
    let guard = trajectory.guarded_from_s().map_or(0, |_| trajectory.guarded_from);
    for index in [0, guard] {
        let Some(knot) = trajectory.knots.get(usize::from(index)) else { continue };
        if knot.qd_rad_s.iter().chain(&knot.qdd_rad_s2).any(|v| v.abs() > REST_MAX) {
            return Err(LoadError::NoRest { knot: index });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
