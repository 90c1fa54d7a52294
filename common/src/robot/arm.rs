//! Where the arm's links are, and how the hand moves with the joints.

use super::tables::{ARM_ORIGINS, HAND_MOUNT, MOUNT_XYZ_M, MOUNT_YAW_RAD};
use crate::limits::ARM_JOINTS;
use nalgebra::{Isometry3, SMatrix, Translation3, UnitQuaternion, Vector3};

/// World-from-base transform of the mounted arm.
pub fn world_from_base() -> Isometry3<f32> {
    let [x, y, z] = MOUNT_XYZ_M;
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), MOUNT_YAW_RAD),
    )
}

/// World-from-link poses at the joint angles `q_rad`: arm links 1..7, then the hand frame (mounting plane).
pub fn link_poses(q_rad: &[f32; ARM_JOINTS]) -> [Isometry3<f32>; 8] {
    link_poses_from(&world_from_base(), q_rad)
}

/// As [`link_poses`], for a base that stands at `world_from_base`.
pub fn link_poses_from(world_from_base: &Isometry3<f32>, q_rad: &[f32; ARM_JOINTS]) -> [Isometry3<f32>; 8] {
    let mut pose = *world_from_base;
    let mut poses = [pose; 8];
    for joint in 0..ARM_JOINTS {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q_rad[joint]);
        pose = pose * ARM_ORIGINS[joint].isometry() * turn;
        poses[joint] = pose;
    }
    poses[7] = pose * HAND_MOUNT.isometry();
    poses
}

/// World-from-hand pose at the joint angles `q_rad`.
pub fn hand_pose(q_rad: &[f32; ARM_JOINTS]) -> Isometry3<f32> {
    let poses = link_poses(q_rad);
    poses[7]
}

/// Jacobian of the hand frame's origin at the joint angles `q_rad`: rows 0-2 its velocity, rows 3-5 the hand's
/// angular velocity, both along world axes, per unit of joint speed (m/rad and rad/rad).
pub fn jacobian(q_rad: &[f32; ARM_JOINTS]) -> SMatrix<f32, 6, 7> {
    let poses = link_poses(q_rad);
    jacobian_at(&poses, &poses[7].translation.vector)
}

/// As [`jacobian`], for the point `point_m` (world) carried by the hand, from poses already known.
pub fn jacobian_at(poses: &[Isometry3<f32>; 8], point_m: &Vector3<f32>) -> SMatrix<f32, 6, 7> {
    let mut jacobian = SMatrix::<f32, 6, 7>::zeros();
    for (joint, pose) in poses.iter().take(ARM_JOINTS).enumerate() {
        let axis = pose.rotation * Vector3::z();
        let lever = point_m - pose.translation.vector;
        let linear = axis.cross(&lever);
        jacobian.fixed_view_mut::<3, 1>(0, joint).copy_from(&linear);
        jacobian.fixed_view_mut::<3, 1>(3, joint).copy_from(&axis);
    }
    jacobian
}

#[cfg(test)]
pub(crate) mod tests;
