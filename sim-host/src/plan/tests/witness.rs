//! A collision check that shares nothing with the planner's but the robot's description: points on the surfaces of all solids, at many instants.

use super::*;
use nalgebra::{Point3, Vector3};
use tactus_common::robot::hand::link_poses;
use tactus_common::robot::{HandLink, MOUNT, hand_prism, world_from_base};
use urdf_rs::Geometry;

/// Whether a point is inside.
type Inside = Box<dyn Fn(&Point3<f32>) -> bool>;

/// A solid in its link's frame, as inequalities and as points on its surface.
pub struct Solid {
    pub link: usize,
    inside: Inside,
    surface_m: Vec<Point3<f32>>,
}

/// Points on the edges of a box, 1 cm apart.
fn box_points(half_m: [f32; 3]) -> Vec<Point3<f32>> {
    let mut points = Vec::new();
    for axis in 0..3 {
        let count = (half_m[axis] / 0.005) as i32 + 1;
        for corner in 0..4 {
            for k in -count..=count {
                let mut p = [0.0; 3];
                p[axis] = half_m[axis] * k as f32 / count as f32;
                p[(axis + 1) % 3] = if corner & 1 == 0 { half_m[(axis + 1) % 3] } else { -half_m[(axis + 1) % 3] };
                p[(axis + 2) % 3] = if corner & 2 == 0 { half_m[(axis + 2) % 3] } else { -half_m[(axis + 2) % 3] };
                points.push(p.into());
            }
        }
    }
    points
}

fn in_box(p: &Point3<f32>, half_m: [f32; 3]) -> bool {
    (0..3).all(|i| p[i].abs() < half_m[i])
}

/// All solids of the robot.
pub fn solids() -> Vec<Solid> {
    let robot = urdf_rs::read_from_string(source::URDF).unwrap();
    let mut solids = Vec::new();
    for link in 0..8 {
        let name = if link == 0 { "wam_base".to_owned() } else { format!("wam_link{link}") };
        for collision in &robot.links.iter().find(|l| l.name == name).unwrap().collision {
            let origin = &collision.origin;
            let [r, p, y] = origin.rpy.0.map(|v| v as f32);
            let [tx, ty, tz] = origin.xyz.0.map(|v| v as f32);
            let pose = Isometry3::from_parts(Translation3::new(tx, ty, tz), UnitQuaternion::from_euler_angles(r, p, y));
            let back = pose.inverse();
            let (inside, points): (Inside, Vec<Point3<f32>>) = match &collision.geometry {
                Geometry::Box { size } => {
                    let half_m = size.0.map(|s| 0.5 * s as f32);
                    (Box::new(move |p| in_box(&(back * p), half_m)), box_points(half_m))
                }
                Geometry::Cylinder { radius, length } => {
                    let (radius, half) = (*radius as f32, 0.5 * *length as f32);
                    let rings = (half / 0.01) as i32 + 1;
                    let ring = (-rings..=rings).flat_map(|k| {
                        (0..16).map(move |a| {
                            let (s, c) = libm::sincosf(PI / 8.0 * a as f32);
                            Point3::new(radius * c, radius * s, half * k as f32 / rings as f32)
                        })
                    });
                    let inside = move |p: &Point3<f32>| {
                        let p = back * p;
                        p.z.abs() < half && p.x * p.x + p.y * p.y < radius * radius
                    };
                    (Box::new(inside), ring.collect())
                }
                other => panic!("{other:?}"),
            };
            solids.push(Solid { link, inside, surface_m: points.iter().map(|p| pose * p).collect() });
        }
    }
    for part in HandLink::ALL {
        let prism = hand_prism(part);
        let mut points = Vec::new();
        for (i, a) in prism.corners_m.iter().enumerate() {
            let b = prism.corners_m[(i + 1) % prism.corners_m.len()];
            for k in 0..4 {
                let s = k as f32 / 4.0;
                for z in [prism.z_m[0], 0.5 * (prism.z_m[0] + prism.z_m[1]), prism.z_m[1]] {
                    points.push(Point3::new(a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), z));
                }
            }
        }
        let inside = move |p: &Point3<f32>| {
            let corners = prism.corners_m;
            let left_of = |(i, a): (usize, &[f32; 2])| {
                let b = corners[(i + 1) % corners.len()];
                (b[0] - a[0]) * (p.y - a[1]) - (b[1] - a[1]) * (p.x - a[0]) > 0.0
            };
            p.z > prism.z_m[0] && p.z < prism.z_m[1] && corners.iter().enumerate().all(left_of)
        };
        solids.push(Solid { link: 8 + part.index(), inside: Box::new(inside), surface_m: points });
    }
    solids
}

/// Where everything is at one posture.
pub fn poses(q_rad: &Joints, angles: &HandAngles) -> Vec<Isometry3<f32>> {
    let arm = arm::link_poses(q_rad);
    let mut poses = vec![world_from_base(&MOUNT)];
    poses.extend_from_slice(&arm[..7]);
    poses.extend_from_slice(&link_poses(&arm[7], angles));
    poses
}

/// What is wrong at one posture: a moving link (2 and on) below the table top, or into a box (`world_from_box`, half edges), or forearm and hand into the rest of the arm.
pub fn complaint(
    solids: &[Solid],
    q_rad: &Joints,
    angles: &HandAngles,
    block: Option<(&Isometry3<f32>, [f32; 3])>,
) -> Option<String> {
    let poses = poses(q_rad, angles);
    for solid in solids {
        let pose = &poses[solid.link];
        for p in &solid.surface_m {
            let p = pose * p;
            if solid.link >= 2 && p.z < 0.0 {
                return Some(format!("link {} at z {}", solid.link, p.z));
            }
            if let Some((world_from_box, half_m)) = block
                && solid.link >= 2
                && in_box(&(world_from_box.inverse() * p), half_m)
            {
                return Some(format!("link {} in the box", solid.link));
            }
        }
        if let Some((world_from_box, half_m)) = block.filter(|_| solid.link >= 2) {
            let link_from_box = pose.inverse() * world_from_box;
            if box_points(half_m).iter().any(|p| (solid.inside)(&(link_from_box * p))) {
                return Some(format!("the box in link {}", solid.link));
            }
        }
        for other in solids.iter().filter(|other| solid.link >= 5 && other.link <= 3) {
            let other_from_link = poses[other.link].inverse() * pose;
            if solid.surface_m.iter().any(|p| (other.inside)(&(other_from_link * p))) {
                return Some(format!("link {} in link {}", solid.link, other.link));
            }
        }
    }
    None
}

/// Angle between two directions, radians; accurate for small ones.
pub fn angle_between(a: &Vector3<f32>, b: &Vector3<f32>) -> f32 {
    libm::atan2f(a.cross(b).norm(), a.dot(b))
}

#[test]
fn the_witness_sees_a_hand_in_the_box_in_the_table_and_in_the_arm() {
    let solids = solids();
    let q = inverse::solve(&down(0.1, -0.1, 0.325, 0.0), 0.0).unwrap()[0];
    let at = |z: f32| PlanarPose::new(0.1, -0.1, 0.0).isometry(z);
    assert_eq!(complaint(&solids, &q, &open_hand(), Some((&at(0.1), HALF_M))), None);
    assert!(complaint(&solids, &q, &open_hand(), Some((&at(0.18), HALF_M))).is_some_and(|c| c.contains("box")));
    let low = inverse::solve(&down(0.1, -0.1, 0.09, 0.0), 0.0).unwrap()[0];
    assert!(complaint(&solids, &low, &open_hand(), None).is_some_and(|c| c.contains("at z")));
    let folded = [0.0, 0.3, 0.0, 3.0, 0.0, 1.5, 0.0];
    assert!(complaint(&solids, &folded, &open_hand(), None).is_some_and(|c| c.contains("in link")));
}
