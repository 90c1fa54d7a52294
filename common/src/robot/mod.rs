//! The Barrett WAM 7-DOF and BarrettHand BH8-280: tables from the URDF, kinematics, dynamics.

/// Placeholder until the robot branch is merged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimit {
    /// Lower limit, radians.
    pub lower_rad: f32,
    /// Upper limit, radians.
    pub upper_rad: f32,
    /// Velocity limit, rad/s.
    pub velocity_rad_s: f32,
    /// Torque limit, N m.
    pub torque_nm: f32,
}
