//! Torques that the arm needs: recursive Newton-Euler in the links' own frames.
//!
//! The hand is one body here (fingers half closed, spread 0): moving the fingers shifts its centre of mass by less
//! than 20 mm. Joint damping is not in these torques; it is in [`super::tables::ARM_DAMPING_NMS_RAD`].

use super::tables::{ARM_INERTIALS, ARM_ORIGINS, GRASP_POINT_Z_M, HAND_LUMPED, HAND_MOUNT, ROTOR_INERTIA_KG_M2};
use crate::limits::ARM_JOINTS;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Acceleration of free fall, m/s^2, along -z of the upright base.
pub const GRAVITY_M_S2: f32 = 9.81;

/// Mass, centre of mass and inertia about it, in one frame.
#[derive(Clone, Copy)]
struct Body {
    mass_kg: f32,
    com_m: Vector3<f32>,
    inertia: Matrix3<f32>,
}

impl Body {
    fn of(link: usize) -> Self {
        let i = &ARM_INERTIALS[link];
        Self { mass_kg: i.mass_kg, com_m: i.com(), inertia: i.inertia() }
    }

    /// The two bodies as one (parallel-axis theorem). Both masses together must not be zero.
    fn joined(self, other: Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        let com_m = (self.com_m * self.mass_kg + other.com_m * other.mass_kg) / mass_kg;
        let moved = |body: &Self| {
            let d = body.com_m - com_m;
            body.inertia + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * body.mass_kg
        };
        Self { mass_kg, com_m, inertia: moved(&self) + moved(&other) }
    }

    /// Arm link 7 with the hand and a payload at the grasp point, in the frame of link 7.
    fn last(payload_kg: f32) -> Self {
        let mount = HAND_MOUNT.isometry();
        let turn = mount.rotation.to_rotation_matrix();
        let hand = Self {
            mass_kg: HAND_LUMPED.mass_kg,
            com_m: mount.translation.vector + turn * HAND_LUMPED.com(),
            inertia: turn * HAND_LUMPED.inertia() * turn.transpose(),
        };
        let grasp_m = mount.translation.vector + turn * Vector3::new(0.0, 0.0, GRASP_POINT_Z_M);
        let payload = Self { mass_kg: payload_kg, com_m: grasp_m, inertia: Matrix3::zeros() };
        Self::of(6).joined(hand).joined(payload)
    }
}

/// Joint torques (N m) for the motion `q_rad`, `qd_rad_s`, `qdd_rad_s2` of the upright arm with the hand and a point
/// mass `payload_kg` (0 or more) at the grasp point. Inertia of the rotors included, damping and friction not.
pub fn inverse_dynamics(
    q_rad: &[f32; ARM_JOINTS],
    qd_rad_s: &[f32; ARM_JOINTS],
    qdd_rad_s2: &[f32; ARM_JOINTS],
    payload_kg: f32,
) -> [f32; ARM_JOINTS] {
    let mut turns = [Matrix3::identity(); ARM_JOINTS];
    let mut forces = [Vector3::zeros(); ARM_JOINTS];
    let mut moments = [Vector3::zeros(); ARM_JOINTS];
    // A base that accelerates upwards feels the same as one in gravity.
    let mut linear = Vector3::new(0.0, 0.0, GRAVITY_M_S2);
    let (mut omega, mut alpha) = (Vector3::zeros(), Vector3::zeros());
    for i in 0..ARM_JOINTS {
        let origin = ARM_ORIGINS[i].isometry();
        let p = origin.translation.vector;
        let turn = (origin.rotation * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q_rad[i]))
            .to_rotation_matrix()
            .into_inner();
        let back = turn.transpose();
        linear = back * (linear + alpha.cross(&p) + omega.cross(&omega.cross(&p)));
        let carried = back * omega;
        let own = Vector3::new(0.0, 0.0, qd_rad_s[i]);
        alpha = back * alpha + carried.cross(&own) + Vector3::new(0.0, 0.0, qdd_rad_s2[i]);
        omega = carried + own;
        let body = if i == 6 { Body::last(payload_kg) } else { Body::of(i) };
        let at_com = linear + alpha.cross(&body.com_m) + omega.cross(&omega.cross(&body.com_m));
        forces[i] = at_com * body.mass_kg;
        moments[i] = body.inertia * alpha + omega.cross(&(body.inertia * omega)) + body.com_m.cross(&forces[i]);
        turns[i] = turn;
    }
    let mut tau_nm = [0.0; ARM_JOINTS];
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for i in (0..ARM_JOINTS).rev() {
        force += forces[i];
        moment += moments[i];
        tau_nm[i] = moment.z + ROTOR_INERTIA_KG_M2[i] * qdd_rad_s2[i];
        // To the frame of the link before.
        force = turns[i] * force;
        moment = turns[i] * moment + Vector3::from(ARM_ORIGINS[i].xyz_m).cross(&force);
    }
    tau_nm
}

/// Joint torques (N m) that hold the arm still at `q_rad` against gravity, payload as in [`inverse_dynamics`].
pub fn gravity(q_rad: &[f32; ARM_JOINTS], payload_kg: f32) -> [f32; ARM_JOINTS] {
    inverse_dynamics(q_rad, &[0.0; ARM_JOINTS], &[0.0; ARM_JOINTS], payload_kg)
}

#[cfg(test)]
mod tests {
    use super::super::hand::{self, HandAngles};
    use super::super::tables::{FINGER_LIMIT, HAND_INERTIALS};
    use super::*;
    use nalgebra::Isometry3;

    #[test]
    fn the_lumped_hand_is_the_sum_of_its_links() {
        let half = 0.5 * (FINGER_LIMIT.lower_rad + FINGER_LIMIT.upper_rad);
        let poses = hand::link_poses(&Isometry3::identity(), &HandAngles::engaged([half; 3], 0.0));
        let bodies = HAND_INERTIALS.iter().zip(&poses).map(|(i, pose)| {
            let turn = pose.rotation.to_rotation_matrix();
            Body {
                mass_kg: i.mass_kg,
                com_m: (pose * nalgebra::Point3::from(i.com())).coords,
                inertia: turn * i.inertia() * turn.transpose(),
            }
        });
        let total = bodies.reduce(Body::joined).unwrap();
        assert!((total.mass_kg - HAND_LUMPED.mass_kg).abs() < 1e-6);
        assert!((total.com_m - HAND_LUMPED.com()).norm() < 1e-6, "{}", total.com_m);
        assert!((total.inertia - HAND_LUMPED.inertia()).norm() < 1e-8, "{}", total.inertia);
    }

    #[test]
    fn an_upright_arm_needs_next_to_no_torque_and_a_stretched_one_its_weight_times_lever() {
        let upright = gravity(&[0.0; 7], 0.0);
        // Not nothing: the forearm, 4.2 kg with the hand, stands 0.045 m behind J4.
        assert!(upright.iter().all(|t| t.abs() < 2.0), "{upright:?}");
        let mut stretched = [0.0; 7];
        stretched[1] = core::f32::consts::FRAC_PI_2;
        let (without, with) = (gravity(&stretched, 0.0), gravity(&stretched, 1.0));
        // 1 kg at 0.55 + 0.30 + 0.06 + 0.16 m from the shoulder, pulling +J2 down: the torque that holds is negative.
        assert!((with[1] - without[1] + 9.81 * 1.07).abs() < 1e-3, "{without:?} {with:?}");
        assert!(with[0].abs() < 1e-3, "gravity does not turn the vertical axis");
    }
}
