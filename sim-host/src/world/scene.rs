//! What stands where: the nominal scene, its table and box, and the check that nothing overlaps.

use super::error::WorldError;
use super::hand::HandStart;
use super::mismatch::Mismatch;
use super::model::RobotModel;
use super::robot::{Robot, groups};
use rapier3d::parry::query;
use rapier3d::prelude::*;
use tactus_common::pose::PlanarPose;

/// Overlap that counts as touching, metres.
const OVERLAP_M: f32 = 2e-4;
/// Thickness of the table top, metres.
const TABLE_THICKNESS_M: f32 = 0.05;

/// The nominal scene, as everybody but reality believes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Half the table top's sides along x and y, metres; its centre is the world's origin.
    pub table_half_m: [f32; 2],
    /// Half the box's sides in its own frame, metres.
    pub half_extents_m: [f32; 3],
    /// Mass of the box, kg.
    pub mass_kg: f32,
    /// Friction between box and table.
    pub table_friction: f32,
    /// Friction between box and pads (also inner links and palm).
    pub pad_friction: f32,
    /// Friction between box and bare metal.
    pub bare_friction: f32,
    /// Where the box truly stands.
    pub object: PlanarPose,
    /// Arm joint angles at the start, radians.
    pub arm_start_rad: [f32; 7],
    /// Hand at the start.
    pub hand_start: HandStart,
}

impl Default for Scene {
    /// The main job: a box of 0.2 x 0.1 x 0.2 m and 0.6 kg at (0.2, -0.1); the hand open, pointing down,
    /// its flange 0.487 m above the table at r = 0.625 from the arm's axis (q2 + q4 + q6 = pi, facts 4.4).
    fn default() -> Self {
        Self {
            table_half_m: [0.915, 0.305],
            half_extents_m: [0.1, 0.05, 0.1],
            mass_kg: 0.6,
            table_friction: 0.3,
            pad_friction: 0.8,
            bare_friction: 0.3,
            object: PlanarPose::new(0.2, -0.1, 0.0),
            arm_start_rad: [0.0, 0.7, 0.0, 1.7, 0.0, 0.741_592_65, 0.0],
            hand_start: HandStart { inner_rad: [0.0; 3], spread_rad: 0.0 },
        }
    }
}

impl Scene {
    /// Half the box's true sides.
    pub fn true_half_extents_m(&self, mismatch: &Mismatch) -> [f32; 3] {
        core::array::from_fn(|i| self.half_extents_m[i] + 0.5 * mismatch.object_size_m[i])
    }

    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// [`WorldError::Scene`] names the first of them.
    pub fn check(&self, model: &RobotModel) -> Result<(), WorldError> {
        let refuse = |what, value: String, expected| Err(WorldError::Scene { what, value, expected });
        if !self.object.is_finite() {
            return refuse("the object's pose", format!("{:?}", self.object.to_array()), "finite numbers");
        }
        if self.object.x_m.abs() > self.table_half_m[0] || self.object.y_m.abs() > self.table_half_m[1] {
            let at = format!("({}, {})", self.object.x_m, self.object.y_m);
            return refuse("the object's centre", at, "a point on the table");
        }
        for (what, value) in [
            ("a half extent of the object", self.half_extents_m[0]),
            ("a half extent of the object", self.half_extents_m[1]),
            ("a half extent of the object", self.half_extents_m[2]),
        ] {
            if !(0.005..=0.5).contains(&value) {
                return refuse(what, format!("{value} m"), "0.005 to 0.5 m");
            }
        }
        if !(0.01..=10.0).contains(&self.mass_kg) {
            return refuse("the object's mass", format!("{} kg", self.mass_kg), "0.01 to 10 kg");
        }
        for friction in [self.table_friction, self.pad_friction, self.bare_friction] {
            if !(0.0..=3.0).contains(&friction) {
                return refuse("a friction coefficient", format!("{friction}"), "0 to 3");
            }
        }
        for (i, name) in model.extra.arm.joints.iter().enumerate() {
            let [lower, upper] = model.joint(name)?.range_rad;
            if !(lower..=upper).contains(&self.arm_start_rad[i]) {
                return refuse(
                    "an arm joint's start",
                    format!("{} = {} rad", name, self.arm_start_rad[i]),
                    "an angle within its limits",
                );
            }
        }
        let hand = &model.extra.hand;
        let fingers = hand.inner_joints.iter().zip(self.hand_start.inner_rad);
        for (name, q_rad) in fingers.chain([(&hand.spread_joints[0], self.hand_start.spread_rad)]) {
            let [lower, upper] = model.joint(name)?.range_rad;
            if !(lower..=upper).contains(&q_rad) {
                return refuse("a hand joint's start", format!("{name} = {q_rad} rad"), "an angle within its limits");
            }
        }
        Ok(())
    }
}

/// Inserts the table top, its upper face at z = 0.
pub fn insert_table(physics: &mut PhysicsWorld, scene: &Scene, mismatch: &Mismatch) -> ColliderHandle {
    let body =
        physics.insert_body(RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -0.5 * TABLE_THICKNESS_M)));
    let collider = ColliderBuilder::cuboid(scene.table_half_m[0], scene.table_half_m[1], 0.5 * TABLE_THICKNESS_M)
        .friction(scene.table_friction * mismatch.table_friction)
        .friction_combine_rule(CoefficientCombineRule::Multiply)
        .collision_groups(groups::table());
    physics.insert_collider(collider, Some(body))
}

/// Inserts the box standing on the table. Friction belongs to the other side of each pair; the box's factor is 1.
pub fn insert_object(
    physics: &mut PhysicsWorld,
    scene: &Scene,
    mismatch: &Mismatch,
) -> (RigidBodyHandle, ColliderHandle) {
    let half = scene.true_half_extents_m(mismatch);
    let body =
        physics.insert_body(RigidBodyBuilder::dynamic().pose(scene.object.isometry(half[2]).into()).can_sleep(false));
    let collider = ColliderBuilder::cuboid(half[0], half[1], half[2])
        .mass(scene.mass_kg * mismatch.object_mass)
        .friction(1.0)
        .friction_combine_rule(CoefficientCombineRule::Multiply)
        .collision_groups(groups::object());
    (body, physics.insert_collider(collider, Some(body)))
}

/// Checks all pairs of colliders that could hurt each other.
///
/// # Errors
/// [`WorldError::Interpenetration`] for the deepest overlap.
pub fn check_overlaps(
    physics: &PhysicsWorld,
    robot: &Robot,
    model: &RobotModel,
    table: ColliderHandle,
    object: ColliderHandle,
) -> Result<(), WorldError> {
    let mut named: Vec<(&str, ColliderHandle, bool)> = vec![("table", table, false), ("object", object, false)];
    named.extend(robot.colliders.iter().map(|c| (c.link.as_str(), c.collider, true)));
    let mut worst: Option<(f32, &str, &str)> = None;
    for (i, (a, first, first_robot)) in named.iter().enumerate() {
        for (b, second, second_robot) in &named[i + 1..] {
            if *first_robot && *second_robot && model.touch_by_construction(a, b) {
                continue;
            }
            let (Some(p), Some(q)) = (physics.colliders.get(*first), physics.colliders.get(*second)) else { continue };
            let found = query::contact(p.position(), p.shape(), q.position(), q.shape(), 0.0);
            let depth = found.ok().flatten().map_or(0.0, |contact| -contact.dist);
            if depth > OVERLAP_M && worst.is_none_or(|(deepest, ..)| depth > deepest) {
                worst = Some((depth, a, b));
            }
        }
    }
    match worst {
        Some((depth_m, a, b)) => Err(WorldError::Interpenetration { a: a.to_owned(), b: b.to_owned(), depth_m }),
        None => Ok(()),
    }
}
