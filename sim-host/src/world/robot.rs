//! Arm and hand as one rapier multibody.
//!
//! Torques act on the arm's joints as they are; the hand's joints are springs whose rest angles its drives move.
//! Traps of rapier 0.36 that this file steps around: a joint gets 0.1 N m s/rad of damping when inserted; a
//! multibody's root counts as free until the first forward kinematics; inserting resets the angle to 0.

use super::drive::JointState;
use super::error::WorldError;
use super::model::{JointModel, LinkModel, RobotModel};
use rapier3d::prelude::*;

#[cfg(test)]
mod probe;

/// Collision groups: who can touch whom.
pub mod groups {
    use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

    const ROBOT: Group = Group::GROUP_1;
    const TABLE: Group = Group::GROUP_2;
    const OBJECT: Group = Group::GROUP_3;

    const fn pairs(own: Group, others: Group) -> InteractionGroups {
        InteractionGroups::new(own, others, InteractionTestMode::And)
    }

    /// The robot touches table and object. Its links are not checked against each other: the planner keeps them apart.
    pub const fn robot() -> InteractionGroups {
        pairs(ROBOT, TABLE.union(OBJECT))
    }

    /// The table, and what is fixed to it, touches robot and objects.
    pub const fn table() -> InteractionGroups {
        pairs(TABLE, ROBOT.union(OBJECT))
    }

    /// An object that stands free touches robot, table and other objects.
    pub const fn object() -> InteractionGroups {
        pairs(OBJECT, ROBOT.union(TABLE).union(OBJECT))
    }
}

/// Index of a joint's angle among the six coordinates of a rapier joint (rotation about its x axis).
const COORDINATE: usize = 3;

/// Stiffness of the springs that stand for motor torques, N m/rad (see [`Robot::set_arm_torques`]).
const TORQUE_SPRING_NM_RAD: f32 = 0.01;

/// A limit nearer than this is armed, radians: two ticks at 50 rad/s.
const LIMIT_REACH_RAD: f32 = 0.2;

/// Where a link's mass, friction and damping differ from the description; 1 everywhere = nominal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotScales {
    /// Mass (and inertia) of arm links 1..7.
    pub arm_mass: [f32; 7],
    /// Mass of the nine hand links.
    pub hand_mass: [f32; 9],
    /// Viscous damping of the arm's joints.
    pub arm_damping: [f32; 7],
    /// Dry friction of the arm's joints.
    pub arm_friction: [f32; 7],
}

impl RobotScales {
    /// The nominal robot.
    pub const NOMINAL: Self =
        Self { arm_mass: [1.0; 7], hand_mass: [1.0; 9], arm_damping: [1.0; 7], arm_friction: [1.0; 7] };
}

/// One joint of the multibody.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    child: RigidBodyHandle,
    link_id: usize,
}

/// One link of the hand and what it collides with.
#[derive(Clone, Debug)]
pub struct HandLinkBody {
    /// Body that carries it (the palm shares link 7's).
    pub body: RigidBodyHandle,
    /// Its collider.
    pub collider: ColliderHandle,
    /// Body-from-link pose.
    pub in_body: Pose,
}

/// Every collider of the robot with its link's name, for checks and messages.
#[derive(Clone, Debug)]
pub struct NamedCollider {
    /// The collider.
    pub collider: ColliderHandle,
    /// Link's name in the URDF.
    pub link: String,
}

/// One link's frame and the body that carries it.
#[derive(Clone, Debug)]
pub struct LinkFrame {
    /// Link's name in the URDF.
    pub link: String,
    /// Body that carries it.
    pub body: RigidBodyHandle,
    /// Body-from-link pose.
    pub in_body: Pose,
}

/// Handles of the robot inside a [`PhysicsWorld`].
#[derive(Clone, Debug)]
pub struct Robot {
    /// Root body: the arm's base, or a stand-in that holds the palm.
    pub root: RigidBodyHandle,
    /// Arm joints J1..J7; empty if the hand alone was built.
    pub arm: Vec<Joint>,
    /// Spread joints of F1 and F2.
    pub spread: [Joint; 2],
    /// Inner joints.
    pub inner: [Joint; 3],
    /// Distal joints.
    pub tip: [Joint; 3],
    /// The nine hand links in contact-matrix order.
    pub hand_links: Vec<HandLinkBody>,
    /// All colliders by name.
    pub colliders: Vec<NamedCollider>,
    /// All links, from the root on.
    pub frames: Vec<LinkFrame>,
}

/// Where the robot is rooted.
#[derive(Clone, Copy, Debug)]
pub enum Root {
    /// The whole arm, its base fixed at this pose (world-from-base).
    Arm(Pose),
    /// The hand alone, its palm fixed at this pose (world-from-hand).
    Hand(Pose),
}

/// Surface friction of links other than the pads, and of the pads.
#[derive(Clone, Copy, Debug)]
pub struct Friction {
    /// Fingertips, inner links and palm (rubber pads).
    pub pads: f32,
    /// Everything else.
    pub bare: f32,
}

/// Dry friction of the arm's joints, N m. No source states it; a cable drive of this size is known to be low, a few
/// per cent of the continuous torque at the shoulder. Assumed.
pub const ARM_FRICTION_NM: [f32; 7] = [0.6, 0.6, 0.4, 0.3, 0.08, 0.08, 0.02];

struct Builder<'a> {
    world: &'a mut PhysicsWorld,
    model: &'a RobotModel,
    friction: Friction,
    colliders: Vec<NamedCollider>,
    frames: Vec<LinkFrame>,
}

fn scaled(link: &LinkModel, scale: f32) -> MassProperties {
    let mut properties = link.mass_properties;
    properties.set_mass(link.mass_kg * scale, true);
    properties
}

impl Builder<'_> {
    fn attach(
        &mut self,
        link: &LinkModel,
        body: RigidBodyHandle,
        in_body: Pose,
        hand_link: Option<usize>,
    ) -> Option<ColliderHandle> {
        self.frames.push(LinkFrame { link: link.name.clone(), body, in_body });
        // Knuckles and the arm are bare; palm, inner links and tips carry rubber.
        let pad = hand_link.is_some_and(|i| i != 1 && i != 4);
        let mut first = None;
        for (at, shape) in &link.shapes {
            let collider = ColliderBuilder::new(shape.clone())
                .position(in_body * *at)
                .density(0.0)
                .user_data(hand_link.map_or(0, |i| i as u128 + 1))
                .friction(if pad { self.friction.pads } else { self.friction.bare })
                .friction_combine_rule(CoefficientCombineRule::Multiply)
                .collision_groups(groups::robot());
            let handle = self.world.insert_collider(collider, Some(body));
            self.colliders.push(NamedCollider { collider: handle, link: link.name.clone() });
            first = first.or(Some(handle));
        }
        first
    }

    fn body(&mut self, properties: MassProperties) -> RigidBodyHandle {
        self.world.insert_body(RigidBodyBuilder::dynamic().additional_mass_properties(properties).can_sleep(false))
    }

    fn joint(
        &mut self,
        parent: RigidBodyHandle,
        parent_from_link: Pose,
        child: RigidBodyHandle,
        joint: &JointModel,
    ) -> Result<Joint, WorldError> {
        let turn = Pose::from_rotation(Rotation::from_rotation_arc(Vector::X, joint.axis));
        let data = GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
            .local_frame1(parent_from_link * joint.origin * turn)
            .local_frame2(turn)
            .limits(JointAxis::AngX, joint.range_rad)
            .contacts_enabled(false)
            .build();
        self.world
            .insert_multibody_joint(parent, child, data)
            .ok_or_else(|| WorldError::Model(format!("joint `{}` closes a loop", joint.name)))?;
        Ok(Joint { child, link_id: 0 })
    }
}

impl Robot {
    /// Inserts the robot at joint angles 0; [`Robot::set_angles`] moves it.
    pub fn insert(
        world: &mut PhysicsWorld,
        model: &RobotModel,
        scales: &RobotScales,
        friction: Friction,
        root_at: Root,
    ) -> Result<Self, WorldError> {
        let hand = &model.extra.hand;
        let mut b = Builder { world, model, friction, colliders: Vec::new(), frames: Vec::new() };
        let mut arm = Vec::new();
        let palm = model.link(&hand.links[0])?;
        let (root, carrier, palm_in_carrier);
        match root_at {
            Root::Hand(world_from_hand) => {
                root = b.world.insert_body(RigidBodyBuilder::fixed().pose(world_from_hand));
                (carrier, palm_in_carrier) = (root, Pose::IDENTITY);
            }
            Root::Arm(world_from_base) => {
                let base = model.link(&model.extra.arm.base)?;
                root = b.world.insert_body(RigidBodyBuilder::fixed().pose(world_from_base));
                b.attach(base, root, Pose::IDENTITY, None);
                let mut parent = root;
                for (i, name) in model.extra.arm.joints.iter().enumerate() {
                    let joint = b.model.joint(name)?;
                    let link = b.model.link(&joint.child)?;
                    let mut properties = scaled(link, scales.arm_mass[i]);
                    if i == 6 {
                        properties += scaled(palm, scales.hand_mass[0]).transform_by(&model.mount);
                    }
                    let body = b.body(properties);
                    b.attach(link, body, Pose::IDENTITY, None);
                    arm.push(b.joint(parent, Pose::IDENTITY, body, joint)?);
                    parent = body;
                }
                (carrier, palm_in_carrier) = (parent, model.mount);
            }
        }
        let mut links: Vec<Option<HandLinkBody>> = vec![None; 9];
        let mut place = |b: &mut Builder, index: usize, body, in_body| -> Result<(), WorldError> {
            let link = model.link(&hand.links[index])?;
            let collider = b
                .attach(link, body, in_body, Some(index))
                .ok_or_else(|| WorldError::Model(format!("link `{}` has no collision shape", link.name)))?;
            links[index] = Some(HandLinkBody { body, collider, in_body });
            Ok(())
        };
        place(&mut b, 0, carrier, palm_in_carrier)?;
        let (mut spread, mut inner, mut tip) = (Vec::new(), Vec::new(), Vec::new());
        for f in 0..3 {
            // Contact-matrix order: palm, F1 knuckle inner tip, F2 knuckle inner tip, F3 inner tip.
            let first = [1, 4, 7][f];
            let (mut parent, mut parent_from_link) = (carrier, palm_in_carrier);
            let mut index = first;
            if f < 2 {
                let joint = model.joint(&hand.spread_joints[f])?;
                let body = b.body(scaled(model.link(&joint.child)?, scales.hand_mass[index]));
                place(&mut b, index, body, Pose::IDENTITY)?;
                spread.push(b.joint(parent, parent_from_link, body, joint)?);
                (parent, parent_from_link) = (body, Pose::IDENTITY);
                index += 1;
            }
            for (joints, name) in [(&mut inner, &hand.inner_joints[f]), (&mut tip, &hand.tip_joints[f])] {
                let joint = model.joint(name)?;
                let body = b.body(scaled(model.link(&joint.child)?, scales.hand_mass[index]));
                place(&mut b, index, body, Pose::IDENTITY)?;
                joints.push(b.joint(parent, parent_from_link, body, joint)?);
                (parent, parent_from_link) = (body, Pose::IDENTITY);
                index += 1;
            }
        }
        let (colliders, frames) = (core::mem::take(&mut b.colliders), core::mem::take(&mut b.frames));
        let wrong = || WorldError::Model("the hand must have 2 spread joints, 3 fingers and 9 links".into());
        let mut robot = Self {
            root,
            arm,
            spread: spread.try_into().map_err(|_| wrong())?,
            inner: inner.try_into().map_err(|_| wrong())?,
            tip: tip.try_into().map_err(|_| wrong())?,
            hand_links: links.into_iter().collect::<Option<Vec<_>>>().ok_or_else(wrong)?,
            colliders,
            frames,
        };
        robot.finish(world, model, scales)?;
        Ok(robot)
    }

    /// Sets damping, friction and rotor inertia, once the multibody is whole.
    fn finish(&mut self, world: &mut PhysicsWorld, model: &RobotModel, scales: &RobotScales) -> Result<(), WorldError> {
        let ids =
            |world: &PhysicsWorld, joint: &Joint| world.multibody_joints.rigid_body_link(joint.child).map(|l| l.id);
        for joint in self.arm.iter_mut().chain(&mut self.spread).chain(&mut self.inner).chain(&mut self.tip) {
            joint.link_id = ids(world, joint).ok_or_else(|| WorldError::Model("a joint is missing".into()))?;
        }
        let hand = &model.extra.hand;
        let PhysicsWorld { bodies, colliders, multibody_joints, .. } = world;
        let index = multibody_joints
            .rigid_body_link(self.inner[0].child)
            .map(|l| l.multibody)
            .ok_or_else(|| WorldError::Model("the hand has no multibody".into()))?;
        let multibody = multibody_joints
            .get_multibody_mut(index)
            .ok_or_else(|| WorldError::Model("the robot is not one multibody".into()))?;
        multibody.set_self_contacts_enabled(false);
        for link in multibody.links() {
            if let Some(body) = bodies.get_mut(link.rigid_body_handle()) {
                body.recompute_mass_properties_from_colliders(colliders);
            }
        }
        multibody.forward_kinematics(bodies, true);
        multibody.damping_mut().fill(0.0);
        let dof =
            |multibody: &Multibody, joint: &Joint| multibody.link(joint.link_id).map_or(0, MultibodyLink::assembly_id);
        for (i, joint) in self.arm.iter().enumerate() {
            let k = dof(multibody, joint);
            let described = model.joint(&model.extra.arm.joints[i])?;
            multibody.damping_mut()[k] = described.damping_nms_rad * scales.arm_damping[i];
            multibody.frictions_mut()[k] = ARM_FRICTION_NM[i] * scales.arm_friction[i];
            multibody.armature_mut()[k] = model.extra.arm.rotor_inertia_kg_m2[i];
        }
        let names = hand.spread_joints.iter().chain(&hand.inner_joints).chain(&hand.tip_joints);
        for (joint, name) in self.spread.iter().chain(&self.inner).chain(&self.tip).zip(names) {
            let k = dof(multibody, joint);
            multibody.damping_mut()[k] = model.joint(name)?.damping_nms_rad;
        }
        multibody.update_rigid_bodies(bodies, true);
        Ok(())
    }

    fn multibody<'a>(&self, world: &'a PhysicsWorld) -> Option<&'a Multibody> {
        let index = world.multibody_joints.rigid_body_link(self.inner[0].child)?.multibody;
        world.multibody_joints.get_multibody(index)
    }

    fn multibody_mut<'a>(&self, world: &'a mut PhysicsWorld) -> Option<&'a mut Multibody> {
        let index = world.multibody_joints.rigid_body_link(self.inner[0].child)?.multibody;
        world.multibody_joints.get_multibody_mut_internal(index)
    }

    /// Adds viscous damping to hand joints, on top of the description's (the shafts' own; N m s/rad).
    pub fn add_hand_damping(&self, world: &mut PhysicsWorld, spread: f32, inner: f32, tip: f32) {
        if let Some(multibody) = self.multibody_mut(world) {
            for (joints, extra) in [(&self.spread[..], spread), (&self.inner[..], inner), (&self.tip[..], tip)] {
                for joint in joints {
                    let k = multibody.link(joint.link_id).map_or(0, MultibodyLink::assembly_id);
                    multibody.damping_mut()[k] += extra;
                }
            }
        }
    }

    /// Moves the joints to these angles at rest.
    pub fn set_angles(&self, world: &mut PhysicsWorld, angles: &[(Joint, f32)]) {
        let PhysicsWorld { bodies, multibody_joints, .. } = world;
        let Some(index) = multibody_joints.rigid_body_link(self.inner[0].child).map(|l| l.multibody) else { return };
        let Some(multibody) = multibody_joints.get_multibody_mut(index) else { return };
        let mut shift = vec![0.0; multibody.ndofs()];
        for (joint, q_rad) in angles {
            if let Some(link) = multibody.link(joint.link_id) {
                shift[link.assembly_id()] = q_rad - link.joint().coords()[COORDINATE];
            }
        }
        multibody.apply_displacements(&shift);
        multibody.generalized_velocity_mut().fill(0.0);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
        let PhysicsWorld { bodies, colliders, .. } = world;
        bodies.propagate_modified_body_positions_to_colliders(colliders);
    }

    /// Angle and speed of a joint.
    pub fn state(&self, world: &PhysicsWorld, joint: &Joint) -> JointState {
        let Some(multibody) = self.multibody(world) else { return JointState::default() };
        let Some(link) = multibody.link(joint.link_id) else { return JointState::default() };
        JointState {
            q_rad: link.joint().coords()[COORDINATE],
            qd_rad_s: multibody.generalized_velocity()[link.assembly_id()],
        }
    }

    /// States of several joints, in one look-up.
    pub fn states<const N: usize>(&self, world: &PhysicsWorld, joints: &[Joint]) -> [JointState; N] {
        let mut out = [JointState::default(); N];
        let Some(multibody) = self.multibody(world) else { return out };
        let velocity = multibody.generalized_velocity();
        for (state, joint) in out.iter_mut().zip(joints) {
            if let Some(link) = multibody.link(joint.link_id) {
                *state =
                    JointState { q_rad: link.joint().coords()[COORDINATE], qd_rad_s: velocity[link.assembly_id()] };
            }
        }
        out
    }

    /// Sets the springs of the hand's joints: stiffness and rest angle each.
    pub fn set_springs(&self, world: &mut PhysicsWorld, springs: &[(Joint, f32, f32)]) {
        if let Some(multibody) = self.multibody_mut(world) {
            for (joint, stiffness, rest) in springs {
                if let Some(link) = multibody.link_mut(joint.link_id) {
                    link.joint.set_spring(COORDINATE, *stiffness, *rest);
                }
            }
        }
    }

    /// Arms the limits of the joints that come near them and disarms the others: rapier pays for each armed limit with a
    /// linear solve a step, reached or not. Call once a tick.
    pub fn arm_limits_in_reach(&self, world: &mut PhysicsWorld) {
        let Some(multibody) = self.multibody_mut(world) else { return };
        for joint in self.arm.iter().chain(&self.spread).chain(&self.inner).chain(&self.tip) {
            if let Some(link) = multibody.link_mut(joint.link_id) {
                let q_rad = link.joint().coords()[COORDINATE];
                let limits = link.joint.data.limits[COORDINATE];
                let near = q_rad < limits.min + LIMIT_REACH_RAD || q_rad > limits.max - LIMIT_REACH_RAD;
                link.joint.data.limit_axes = if near { JointAxesMask::ANG_X } else { JointAxesMask::empty() };
            }
        }
    }

    /// Makes `tau_nm` act on the arm's joints for the coming step, whose angles are `q_rad`.
    ///
    /// A very soft spring whose rest lies far away is a constant torque: exact at one substep a step, it reaches the
    /// generalised force directly (no pair of world torques to round), and touches no body, so that rapier need not look
    /// for changes. Its stiffness adds a damping of `TORQUE_SPRING * dt` = 5e-6 N m s/rad.
    pub fn set_arm_torques(&self, world: &mut PhysicsWorld, q_rad: &[f32; 7], tau_nm: &[f32; 7]) {
        if let Some(multibody) = self.multibody_mut(world) {
            for (i, joint) in self.arm.iter().enumerate() {
                if let Some(link) = multibody.link_mut(joint.link_id) {
                    link.joint.set_spring(
                        COORDINATE,
                        TORQUE_SPRING_NM_RAD,
                        q_rad[i] + tau_nm[i] / TORQUE_SPRING_NM_RAD,
                    );
                }
            }
        }
    }

    /// World pose of a hand link's frame.
    pub fn hand_link_pose(&self, world: &PhysicsWorld, index: usize) -> Pose {
        let link = &self.hand_links[index];
        world.bodies.get(link.body).map_or(Pose::IDENTITY, |b| *b.position() * link.in_body)
    }
}
