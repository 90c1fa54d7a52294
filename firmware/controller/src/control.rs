//! Joint torques that make the arm follow its reference: inverse dynamics plus a position law.
//!
//! `tau = RNEA(q, qd_ref, qdd_ref) + Kp (q_ref - q) + Kd (qd_ref - qd)`, clamped to the joints' limits. The
//! gravity part uses the nominal masses of the mental model; what reality differs is left to `Kp`.

use tactus_common::limits::{ARM_JOINTS, TICK_S};
use tactus_common::robot::tables::{ARM_KD_NMS_RAD, ARM_KP_NM_RAD};
use tactus_common::robot::{ARM_LIMITS, dynamics};
use tactus_common::trajectory::Sample;

/// Share of the newest difference in the velocity estimate; one encoder count a tick is 0.02 rad/s on J1.
const VELOCITY_FILTER: f32 = 0.35;

/// The position law's state: the velocity estimate.
#[derive(Clone, Copy, Debug)]
pub struct JointControl {
    before: Option<(u32, [f32; ARM_JOINTS])>,
    qd_rad_s: [f32; ARM_JOINTS],
}

impl Default for JointControl {
    fn default() -> Self {
        Self { before: None, qd_rad_s: [0.0; ARM_JOINTS] }
    }
}

impl JointControl {
    /// Takes the joint angles measured at `tick`; ticks for which none came are counted in, so that a gap does not look
    /// like speed. Angles of a tick that is not newer are passed over.
    pub fn observe(&mut self, tick: u32, q_rad: &[f32; ARM_JOINTS]) {
        if let Some((tick_before, q_before_rad)) = self.before {
            let ticks = tick.saturating_sub(tick_before);
            if ticks == 0 {
                return;
            }
            for j in 0..ARM_JOINTS {
                let newest = (q_rad[j] - q_before_rad[j]) / (ticks as f32 * TICK_S);
                self.qd_rad_s[j] += VELOCITY_FILTER * (newest - self.qd_rad_s[j]);
            }
        }
        self.before = Some((tick, *q_rad));
    }

    /// Filtered joint velocities, rad/s.
    pub fn velocity_rad_s(&self) -> &[f32; ARM_JOINTS] {
        &self.qd_rad_s
    }

    /// Joint torques, newton-metres, within the joints' limits.
    pub fn torques(&self, q_rad: &[f32; ARM_JOINTS], reference: &Sample, payload_kg: f32) -> [f32; ARM_JOINTS] {
        let feedforward = dynamics::inverse_dynamics(q_rad, &reference.qd_rad_s, &reference.qdd_rad_s2, payload_kg);
        let mut tau_nm = [0.0; ARM_JOINTS];
        for j in 0..ARM_JOINTS {
            let tau = feedforward[j]
                + ARM_KP_NM_RAD[j] * (reference.q_rad[j] - q_rad[j])
                + ARM_KD_NMS_RAD[j] * (reference.qd_rad_s[j] - self.qd_rad_s[j]);
            let limit = ARM_LIMITS[j].torque_nm;
            tau_nm[j] = if tau.is_finite() { tau.clamp(-limit, limit) } else { 0.0 };
        }
        tau_nm
    }
}

#[cfg(test)]
mod tests;
