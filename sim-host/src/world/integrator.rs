//! A correction that makes the arm's integration second order.
//!
//! Rapier evaluates Coriolis and centrifugal torques c(q, v) at the *end* of a step (linearised, implicit). That is
//! stable, and it brakes: a freely falling arm loses 40 % of its energy in 10 s at 2 kHz. Positions at whole steps
//! and velocities between them form a leapfrog, which is second order and time-reversible, if c is taken at the mean
//! of the two velocities instead. With a forecast d of the coming step's change of velocity (extrapolated from the last
//! two), the difference is half of d's effect; c is quadratic in v, so central differences give it exactly:
//! `tau = (c(q, v + d) - c(q, v - d)) / 4`.

use tactus_common::limits::ARM_JOINTS;
use tactus_common::robot::dynamics::inverse_dynamics;

/// Largest change of a joint's velocity in one step that is believed, rad/s: bounds the correction in an impact.
const CHANGE_MAX_RAD_S: f32 = 5.0;

/// What the forecast remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Midpoint {
    /// Velocities at the last step, rad/s.
    pub before_rad_s: [f32; ARM_JOINTS],
    /// Change of the velocities in the last step, rad/s.
    pub change_rad_s: [f32; ARM_JOINTS],
}

impl Midpoint {
    /// Torques (N m) that move the evaluation of the velocity terms from the end of the coming step to its middle,
    /// from the present angles and velocities; call once a step. The hand counts as one body.
    pub fn torques(&mut self, q_rad: &[f32; ARM_JOINTS], qd_rad_s: &[f32; ARM_JOINTS]) -> [f32; ARM_JOINTS] {
        let change: [f32; ARM_JOINTS] = core::array::from_fn(|i| qd_rad_s[i] - self.before_rad_s[i]);
        let forecast: [f32; ARM_JOINTS] = core::array::from_fn(|i| {
            (2.0 * change[i] - self.change_rad_s[i]).clamp(-CHANGE_MAX_RAD_S, CHANGE_MAX_RAD_S)
        });
        (self.before_rad_s, self.change_rad_s) = (*qd_rad_s, change);
        let ahead = core::array::from_fn(|i| qd_rad_s[i] + forecast[i]);
        let behind = core::array::from_fn(|i| qd_rad_s[i] - forecast[i]);
        let still = [0.0; ARM_JOINTS];
        let (a, b) = (inverse_dynamics(q_rad, &ahead, &still, 0.0), inverse_dynamics(q_rad, &behind, &still, 0.0));
        core::array::from_fn(|i| 0.25 * (a[i] - b[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_corrected_at_constant_speed() {
        let q = [0.1, 0.5, -0.3, 1.2, 0.4, 0.2, 0.0];
        let v = [0.5, -0.4, 0.3, 0.8, -1.0, 0.6, 0.9];
        let mut midpoint = Midpoint { before_rad_s: v, ..Midpoint::default() };
        assert_eq!(midpoint.torques(&q, &v), [0.0; 7]);
        assert!(midpoint.torques(&q, &[0.4; 7]).iter().any(|t| t.abs() > 1e-3));
    }
}
