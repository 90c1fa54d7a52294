//! A correction that makes the arm's integration second order.
//!
//! Rapier evaluates Coriolis and centrifugal torques c(q, v) at the *end* of a step (linearised, implicit). That is
//! stable, and it brakes: a freely swinging arm loses 40 % of its energy in 10 s at 2 kHz. Positions at whole steps
//! and velocities between them form a leapfrog, which is second order and time-reversible, if c is taken at the mean
//! of the two velocities instead. With the last step's change of velocity d as forecast of the next, the difference is
//! half of d's effect; c is quadratic in v, so central differences give it exactly:
//! `tau = (c(q, v + d) - c(q, v - d)) / 4`.

use tactus_common::limits::ARM_JOINTS;
use tactus_common::robot::dynamics::inverse_dynamics;

/// Change of a joint's velocity in one step beyond which the forecast is not believed (an impact), rad/s.
const JUMP_MAX_RAD_S: f32 = 0.5;

/// Torques (N m) that move the evaluation of the velocity terms from the end of the coming step to its middle, from
/// the present angles and velocities and the velocities one step before. The hand counts as one body.
pub fn midpoint_torques(
    q_rad: &[f32; ARM_JOINTS],
    qd_rad_s: &[f32; ARM_JOINTS],
    qd_before_rad_s: &[f32; ARM_JOINTS],
) -> [f32; ARM_JOINTS] {
    let change: [f32; ARM_JOINTS] =
        core::array::from_fn(|i| (qd_rad_s[i] - qd_before_rad_s[i]).clamp(-JUMP_MAX_RAD_S, JUMP_MAX_RAD_S));
    let ahead = core::array::from_fn(|i| qd_rad_s[i] + change[i]);
    let behind = core::array::from_fn(|i| qd_rad_s[i] - change[i]);
    let still = [0.0; ARM_JOINTS];
    let (a, b) = (inverse_dynamics(q_rad, &ahead, &still, 0.0), inverse_dynamics(q_rad, &behind, &still, 0.0));
    core::array::from_fn(|i| 0.25 * (a[i] - b[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_corrected_at_constant_speed_or_at_rest() {
        let q = [0.1, 0.5, -0.3, 1.2, 0.4, 0.2, 0.0];
        let v = [0.5, -0.4, 0.3, 0.8, -1.0, 0.6, 0.9];
        assert_eq!(midpoint_torques(&q, &v, &v), [0.0; 7]);
        assert!(midpoint_torques(&q, &v, &[0.4; 7]).iter().any(|t| t.abs() > 1e-3));
    }
}
