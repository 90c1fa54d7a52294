//! What stands where: the nominal scene, its bodies in a world, and the check that nothing overlaps.

use super::error::WorldError;
use super::hand::HandStart;
use super::mismatch::Mismatch;
use super::model::RobotModel;
use super::robot::{Robot, groups};
use super::rolling::Rolling;
use crate::solid::Solid;
use rapier3d::parry::query;
use rapier3d::prelude::*;
use serde::Serialize;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::MOUNT;
use tactus_common::shape::ObjectShape;

/// Overlap that counts as touching, metres.
const OVERLAP_M: f32 = 2e-4;
/// Thickness of the table top, metres.
const TABLE_THICKNESS_M: f32 = 0.05;

/// A body that stands on the table beside the object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// Name, for messages.
    pub name: String,
    /// Its shape.
    pub shape: ObjectShape,
    /// Where it stands.
    pub pose: PlanarPose,
    /// Mass of a body that can be pushed, kg; `None` if it is fixed to the table.
    pub free_kg: Option<f32>,
}

/// The nominal scene, as everybody but reality believes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Half the table top's sides along x and y, metres; its centre is the world's origin.
    pub table_half_m: [f32; 2],
    /// The object's shape.
    pub shape: ObjectShape,
    /// Mass of the object, kg.
    pub mass_kg: f32,
    /// Friction between object and table.
    pub table_friction: f32,
    /// Friction between object and pads (also inner links and palm).
    pub pad_friction: f32,
    /// Friction between object and bare metal.
    pub bare_friction: f32,
    /// Where the object truly stands.
    pub object: PlanarPose,
    /// What else stands on the table.
    pub others: Vec<Standing>,
    /// Where the robot's base stands.
    pub robot_base: PlanarPose,
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
            shape: ObjectShape::THESIS_BOX,
            mass_kg: 0.6,
            table_friction: 0.3,
            pad_friction: 0.8,
            bare_friction: 0.3,
            object: PlanarPose::new(0.2, -0.1, 0.0),
            others: Vec::new(),
            robot_base: MOUNT,
            arm_start_rad: [0.0, 0.7, 0.0, 1.7, 0.0, 0.741_592_65, 0.0],
            hand_start: HandStart { inner_rad: [0.0; 3], spread_rad: 0.0 },
        }
    }
}

impl Scene {
    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// [`WorldError::Scene`] names the first of them.
    pub fn check(&self, model: &RobotModel) -> Result<(), WorldError> {
        let refuse = |what: String, value: String, expected| Err(WorldError::Scene { what, value, expected });
        self.check_body("the object", &self.shape, &self.object)?;
        for other in &self.others {
            self.check_body(&other.name, &other.shape, &other.pose)?;
        }
        if !(0.01..=10.0).contains(&self.mass_kg) {
            return refuse("the object's mass".into(), format!("{} kg", self.mass_kg), "0.01 to 10 kg");
        }
        for friction in [self.table_friction, self.pad_friction, self.bare_friction] {
            if !(0.0..=3.0).contains(&friction) {
                return refuse("a friction coefficient".into(), format!("{friction}"), "0 to 3");
            }
        }
        for (i, name) in model.extra.arm.joints.iter().enumerate() {
            let [lower, upper] = model.joint(name)?.range_rad;
            if !(lower..=upper).contains(&self.arm_start_rad[i]) {
                return refuse(
                    "an arm joint's start".into(),
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
                return refuse(
                    "a hand joint's start".into(),
                    format!("{name} = {q_rad} rad"),
                    "an angle within its limits",
                );
            }
        }
        Ok(())
    }

    /// Refuses a shape of a size that is not simulated, and a body that does not stand over the table.
    fn check_body(&self, name: &str, shape: &ObjectShape, pose: &PlanarPose) -> Result<(), WorldError> {
        let refuse = |what: &str, value: String, expected| {
            Err(WorldError::Scene { what: format!("{what} of {name}"), value, expected })
        };
        if !pose.is_finite() {
            return refuse("the pose", format!("{:?}", pose.to_array()), "finite numbers");
        }
        if pose.x_m.abs() > self.table_half_m[0] || pose.y_m.abs() > self.table_half_m[1] {
            return refuse("the centre", format!("({}, {})", pose.x_m, pose.y_m), "a point on the table");
        }
        if !shape.is_valid() {
            return refuse("the shape", "not valid".into(), "positive finite dimensions");
        }
        if let Some(half_m) = shape.half_extents_m().iter().find(|half_m| !(0.005..=0.5).contains(*half_m)) {
            return refuse("a half extent", format!("{half_m} m"), "0.005 to 0.5 m");
        }
        Ok(())
    }
}

/// A body in a world.
#[derive(Clone, Copy, Debug)]
pub struct Inserted {
    /// Its body.
    pub body: RigidBodyHandle,
    /// Its collider.
    pub collider: ColliderHandle,
    /// Half the extents of its bounding box, metres.
    pub half_extents_m: [f32; 3],
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

/// Inserts the object standing on the table, as `mismatch` makes it. Friction belongs to the other side of each pair; the
/// object's factor is 1.
///
/// # Errors
/// [`WorldError::Scene`] if its shape is none that can be simulated.
pub fn insert_object(
    physics: &mut PhysicsWorld,
    rolling: &mut Rolling,
    scene: &Scene,
    mismatch: &Mismatch,
) -> Result<Inserted, WorldError> {
    let solid = solid_of("the object", &scene.shape, &mismatch.object_size_m)?;
    let mass_kg = scene.mass_kg * mismatch.object_mass;
    Ok(insert_free(physics, rolling, &solid, &scene.object, mass_kg))
}

/// Inserts another body: what is free as the object, what is fixed with the table's friction. Both are as the scene says.
///
/// # Errors
/// As [`insert_object`].
pub fn insert_other(
    physics: &mut PhysicsWorld,
    rolling: &mut Rolling,
    scene: &Scene,
    mismatch: &Mismatch,
    other: &Standing,
) -> Result<Inserted, WorldError> {
    let solid = solid_of(&other.name, &other.shape, &[0.0; 3])?;
    if let Some(mass_kg) = other.free_kg {
        return Ok(insert_free(physics, rolling, &solid, &other.pose, mass_kg));
    }
    let stands = other.pose.isometry(solid.rest_height_m).into();
    let body = physics.insert_body(RigidBodyBuilder::fixed().pose(stands));
    let collider = ColliderBuilder::new(solid.shape)
        .position(solid.in_body)
        .friction(scene.table_friction * mismatch.table_friction)
        .friction_combine_rule(CoefficientCombineRule::Multiply)
        .collision_groups(groups::table());
    let collider = physics.insert_collider(collider, Some(body));
    Ok(Inserted { body, collider, half_extents_m: solid.half_extents_m })
}

fn solid_of(name: &str, shape: &ObjectShape, more_m: &[f32; 3]) -> Result<Solid, WorldError> {
    let refused = || WorldError::Scene {
        what: format!("the shape of {name}"),
        value: format!("no solid with {more_m:?} m more"),
        expected: "a convex solid",
    };
    Solid::resized(shape, more_m).ok_or_else(refused)
}

fn insert_free(
    physics: &mut PhysicsWorld,
    rolling: &mut Rolling,
    solid: &Solid,
    at: &PlanarPose,
    mass_kg: f32,
) -> Inserted {
    let stands = at.isometry(solid.rest_height_m).into();
    let body = physics.insert_body(RigidBodyBuilder::dynamic().pose(stands).can_sleep(false));
    let collider = solid
        .collider(mass_kg)
        .friction(1.0)
        .friction_combine_rule(CoefficientCombineRule::Multiply)
        .collision_groups(groups::object());
    let collider = physics.insert_collider(collider, Some(body));
    if let Some(radius_m) = solid.roll_radius_m {
        rolling.add(body, collider, radius_m);
    }
    Inserted { body, collider, half_extents_m: solid.half_extents_m }
}

/// A collider with its name and what it belongs to, for [`check_overlaps`].
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// Name, for messages.
    pub name: &'a str,
    /// The collider.
    pub collider: ColliderHandle,
    /// It cannot move, and may lie in others that cannot.
    pub is_fixed: bool,
}

/// Checks all pairs of colliders that could hurt each other.
///
/// # Errors
/// [`WorldError::Interpenetration`] for the deepest overlap.
pub fn check_overlaps(
    physics: &PhysicsWorld,
    robot: &Robot,
    model: &RobotModel,
    bodies: &[Named<'_>],
) -> Result<(), WorldError> {
    let mut named: Vec<(Named<'_>, bool)> = bodies.iter().map(|body| (*body, false)).collect();
    named
        .extend(robot.colliders.iter().map(|c| (Named { name: &c.link, collider: c.collider, is_fixed: false }, true)));
    let mut worst: Option<(f32, &str, &str)> = None;
    for (i, (first, first_robot)) in named.iter().enumerate() {
        for (second, second_robot) in &named[i + 1..] {
            let (a, b) = (first.name, second.name);
            let may_meet = *first_robot && *second_robot && model.touch_by_construction(a, b);
            if may_meet || (first.is_fixed && second.is_fixed) {
                continue;
            }
            let (first, second) = (physics.colliders.get(first.collider), physics.colliders.get(second.collider));
            let (Some(p), Some(q)) = (first, second) else { continue };
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
