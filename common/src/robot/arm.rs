//! Where the arm's links are, and how the hand moves with the joints.

use super::tables::{ARM_ORIGINS, HAND_MOUNT, MOUNT_XYZ_M, MOUNT_YAW_RAD};
use crate::limits::ARM_JOINTS;
use crate::pose::PlanarPose;
use nalgebra::{Isometry3, SMatrix, UnitQuaternion, Vector3};

/// Where the arm's base stands unless a scene says otherwise: x, y (metres) and yaw (radians) of its frame in the world.
pub const MOUNT: PlanarPose = PlanarPose::new(MOUNT_XYZ_M[0], MOUNT_XYZ_M[1], MOUNT_YAW_RAD);

/// World-from-base transform of an arm whose base stands at `mount`, on the table's level.
pub fn world_from_base(mount: &PlanarPose) -> Isometry3<f32> {
    mount.isometry(MOUNT_XYZ_M[2])
}

/// World-from-link poses at the joint angles `q_rad`, with the base at [`MOUNT`]: arm links 1..7, then the hand frame
/// (mounting plane).
pub fn link_poses(q_rad: &[f32; ARM_JOINTS]) -> [Isometry3<f32>; 8] {
    link_poses_from(&world_from_base(&MOUNT), q_rad)
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

/// World-from-hand pose at the joint angles `q_rad`, with the base at [`MOUNT`].
pub fn hand_pose(q_rad: &[f32; ARM_JOINTS]) -> Isometry3<f32> {
    hand_pose_from(&MOUNT, q_rad)
}

/// As [`hand_pose`], with the base at `mount`.
pub fn hand_pose_from(mount: &PlanarPose, q_rad: &[f32; ARM_JOINTS]) -> Isometry3<f32> {
    let poses = link_poses_from(&world_from_base(mount), q_rad);
    poses[7]
}

/// Jacobian of the hand frame's origin at the joint angles `q_rad`: rows 0-2 its velocity, rows 3-5 the hand's
/// angular velocity, both along world axes with the base at [`MOUNT`], per unit of joint speed (m/rad and rad/rad).
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
