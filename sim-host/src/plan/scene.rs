//! What the robot may not run into, and whether a posture or a motion keeps clear of it.

use super::Joints;
use super::body::{Body, HAND, ModelError, bodies};
use crate::solid::Solid;
use rapier3d::parry::bounding_volume::BoundingSphere;
use rapier3d::parry::math::{Pose, Vector};
use rapier3d::parry::query;
use rapier3d::parry::shape::SharedShape;
use tactus_common::robot::hand::{self, HandAngles};
use tactus_common::robot::{HandLink, MOUNT, arm, world_from_base};
use tactus_common::shape::Obstacle;

/// Farthest that any part of robot or load lies from the axis of each joint, metres (facts 1.1, 1.4, 2.6: stretched arm 0.91 + hand 0.20).
const LEVER_M: [f32; 7] = [1.1, 1.1, 0.65, 0.57, 0.30, 0.29, 0.17];

/// A box that the robot must not touch.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// World-from-box.
    pub pose: Pose,
    /// Half of the edges, metres.
    pub half_m: Vector,
}

/// What the hand carries.
#[derive(Clone)]
pub struct Load {
    /// Hand-from-shape.
    pose: Pose,
    /// Its shape; a support map.
    shape: SharedShape,
    /// Bounding sphere, frame of the shape.
    sphere: BoundingSphere,
    /// It comes from the table or goes down to it: only obstacles count.
    near_table: bool,
}

impl Load {
    /// A load off the table: its hand-from-shape pose and its shape.
    pub fn new(pose: Pose, shape: SharedShape) -> Self {
        Self { pose, sphere: shape.compute_local_bounding_sphere(), shape, near_table: false }
    }

    /// The same where it comes from the table or goes down to it.
    pub fn at_the_table(self) -> Self {
        Self { near_table: true, ..self }
    }
}

/// How far parts of the robot keep from obstacles.
#[derive(Clone, Copy, Debug)]
pub struct Clearance {
    /// Distance, metres.
    pub margin_m: f32,
    /// Whether the fingers keep it too; they may touch an obstacle where they have just closed.
    pub of_fingers: bool,
}

/// What counts as a collision in one part of a motion.
#[derive(Clone)]
pub struct Rules {
    /// Height above the table top that moving parts must keep, metres.
    pub table_margin_m: f32,
    /// Distance that hand and forearm keep from base and upper arm, metres.
    pub self_margin_m: f32,
    /// The object on the table.
    pub object: Option<Block>,
    /// Whether the fingers may meet the object, and only arm, palm and knuckles keep away from it.
    pub fingers_may_touch: bool,
    /// What the hand holds: it must keep off obstacles, the table and the arm.
    pub carried: Option<Load>,
    /// How far everything keeps from obstacles.
    pub obstacles: Clearance,
}

/// What a posture runs into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hit {
    /// The table, or the space below its top beside it.
    Table,
    /// The object on the table.
    Object,
    /// What else stands on the table (or what is carried meets it).
    Obstacle,
    /// The robot itself (or what it carries meets the robot).
    Itself,
}

/// The robot's solids and the pairs of them that can meet.
pub struct Scene {
    bodies: Vec<Body>,
    pairs: Vec<(usize, usize)>,
    obstacles: Vec<Fixed>,
}

/// An obstacle.
struct Fixed {
    /// World-from-shape.
    pose: Pose,
    shape: SharedShape,
    /// Bounding sphere, world frame, metres.
    centre_m: Vector,
    radius_m: f32,
}

impl Fixed {
    fn new(obstacle: &Obstacle) -> Option<Self> {
        let Solid { in_body, shape, .. } = Solid::new(&obstacle.shape)?;
        let pose = Pose::from(obstacle.isometry()) * in_body;
        let sphere = shape.compute_local_bounding_sphere();
        Some(Self { pose, centre_m: pose * sphere.center, radius_m: sphere.radius, shape })
    }

    /// Whether a shape, whose bounding sphere is given, comes nearer than `margin_m`.
    fn near(&self, centre_m: Vector, radius_m: f32, shape: &SharedShape, pose: &Pose, margin_m: f32) -> bool {
        let reach_m = self.radius_m + radius_m + margin_m;
        if (self.centre_m - centre_m).length_squared() > reach_m * reach_m {
            return false;
        }
        query::distance(&self.pose, &*self.shape, pose, &**shape).map_or(true, |d| d.distance <= margin_m)
    }
}

impl Scene {
    /// The scene for a robot at [`MOUNT`] among obstacles.
    ///
    /// # Errors
    /// [`ModelError`] as from [`bodies`], or for an obstacle that is no solid.
    pub fn new<'o>(
        robot: &urdf_rs::Robot,
        obstacles: impl IntoIterator<Item = &'o Obstacle>,
    ) -> Result<Self, ModelError> {
        let bodies = bodies(robot)?;
        let mut pairs = Vec::new();
        for (i, a) in bodies.iter().enumerate() {
            for (k, b) in bodies.iter().enumerate() {
                if may_meet(a.link, b.link) {
                    pairs.push((i, k));
                }
            }
        }
        let fixed = |(index, obstacle)| Fixed::new(obstacle).ok_or(ModelError::Obstacle(index));
        let obstacles = obstacles.into_iter().enumerate().map(fixed).collect::<Result<_, _>>()?;
        Ok(Self { bodies, pairs, obstacles })
    }

    /// Poses of all links in the frame in which the base stands at [`MOUNT`]: base, arm links 1 to 7, hand links.
    fn link_poses(q_rad: &Joints, angles: &HandAngles) -> [Pose; HAND + 9] {
        let arm = arm::link_poses(q_rad);
        let hand = hand::link_poses(&arm[7], angles);
        let mut poses = [Pose::IDENTITY; HAND + 9];
        poses[0] = world_from_base(&MOUNT).into();
        for (pose, isometry) in poses.iter_mut().skip(1).zip(arm.iter().take(7).chain(&hand)) {
            *pose = (*isometry).into();
        }
        poses
    }

    /// What the posture runs into, if anything.
    pub fn hit(&self, q_rad: &Joints, angles: &HandAngles, rules: &Rules) -> Option<Hit> {
        let poses = Self::link_poses(q_rad, angles);
        // Links 0 and 1 stand on the table's level by construction.
        for body in self.bodies.iter().filter(|body| body.link >= 2) {
            let pose = &poses[body.link];
            if body.centre(pose).z - body.radius_m < rules.table_margin_m && body.lowest_m(pose) < rules.table_margin_m
            {
                return Some(Hit::Table);
            }
        }
        if let Some(object) = &rules.object {
            // Base and shoulder turn on the spot: where the object may be overlaps them, no motion can help.
            let movers = self.bodies.iter().filter(|body| body.link >= 2);
            for body in movers.filter(|body| !(rules.fingers_may_touch && is_finger(body.link))) {
                if body.meets_box(&poses[body.link], &object.pose, object.half_m) {
                    return Some(Hit::Object);
                }
            }
        }
        if self.obstacle_hit(&poses, &rules.obstacles) {
            return Some(Hit::Obstacle);
        }
        for (i, k) in &self.pairs {
            let (a, b) = (&self.bodies[*i], &self.bodies[*k]);
            if a.near(&poses[a.link], b, &poses[b.link], rules.self_margin_m) {
                return Some(Hit::Itself);
            }
        }
        rules.carried.as_ref().and_then(|load| self.load_hit(&poses, load, rules))
    }

    /// Whether a part of the robot is too near to an obstacle. Base and shoulder turn on the spot, beside the table.
    fn obstacle_hit(&self, poses: &[Pose; HAND + 9], clearance: &Clearance) -> bool {
        let movers = self.bodies.iter().filter(|body| body.link >= 2);
        let mut movers = movers.filter(|body| clearance.of_fingers || !is_finger(body.link));
        !self.obstacles.is_empty()
            && movers.any(|body| {
                let (centre, pose) = (body.centre(&poses[body.link]), body.pose(&poses[body.link]));
                let near = |o: &Fixed| o.near(centre, body.radius_m, body.shape(), &pose, clearance.margin_m);
                self.obstacles.iter().any(near)
            })
    }

    /// What a carried body runs into; its height is that of its lowest point.
    fn load_hit(&self, poses: &[Pose; HAND + 9], load: &Load, rules: &Rules) -> Option<Hit> {
        let world_from_shape = poses[HAND] * load.pose;
        let (centre, radius_m) = (world_from_shape * load.sphere.center, load.sphere.radius);
        let near = |o: &Fixed| o.near(centre, radius_m, &load.shape, &world_from_shape, rules.obstacles.margin_m);
        if self.obstacles.iter().any(near) {
            return Some(Hit::Obstacle);
        }
        if load.near_table {
            return None;
        }
        let support = load.shape.as_support_map();
        let lowest_m = support.map_or(f32::MIN, |shape| shape.support_point_toward(&world_from_shape, -Vector::Z).z);
        if lowest_m < rules.table_margin_m {
            return Some(Hit::Table);
        }
        let mut arm = self.bodies.iter().filter(|body| body.link <= 4);
        arm.any(|body| body.meets(&poses[body.link], &load.shape, &world_from_shape)).then_some(Hit::Itself)
    }

    /// What a straight motion in joint space runs into, both ends included, looked at in steps in which no point of the robot moves more than `step_m`.
    pub fn segment_hit(
        &self,
        from: &Joints,
        to: &Joints,
        angles: &HandAngles,
        rules: &Rules,
        step_m: f32,
    ) -> Option<Hit> {
        let steps = ((travel_m(from, to) / step_m) as usize + 1).next_power_of_two();
        if let Some(hit) = self.hit(from, angles, rules).or_else(|| self.hit(to, angles, rules)) {
            return Some(hit);
        }
        // Coarse first: the middle, the quarters, ... so that a collision is met early.
        let mut stride = steps;
        while stride > 1 {
            for k in (stride / 2..steps).step_by(stride) {
                let s = k as f32 / steps as f32;
                if let Some(hit) = self.hit(&between(from, to, s), angles, rules) {
                    return Some(hit);
                }
            }
            stride /= 2;
        }
        None
    }
}

/// Upper bound of the way that any point of the robot makes between two postures, metres.
pub fn travel_m(from: &Joints, to: &Joints) -> f32 {
    LEVER_M.iter().zip(from.iter().zip(to)).map(|(lever, (a, b))| lever * (a - b).abs()).sum()
}

/// The posture at part `s` of the straight motion.
pub fn between(from: &Joints, to: &Joints, s: f32) -> Joints {
    core::array::from_fn(|j| from[j] + s * (to[j] - from[j]))
}

/// Inner and tip links of the fingers; the knuckles lie in the palm's plane and count as palm.
fn is_finger(link: usize) -> bool {
    let palm_like = [HandLink::Palm, HandLink::F1Knuckle, HandLink::F2Knuckle];
    link >= HAND && palm_like.iter().all(|part| HAND + part.index() != link)
}

/// Coarse: what lies beyond the elbow against what lies before it, the hand against the forearm, the upper arm against the base.
fn may_meet(a: usize, b: usize) -> bool {
    match a {
        0..3 => false,
        3 => b == 0,
        4 => b <= 2,
        5..HAND => b <= 3,
        HAND.. => b <= 4,
    }
}
