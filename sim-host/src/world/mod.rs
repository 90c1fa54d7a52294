//! The simulated world: arm, hand, table, an object and what else stands there, with the robot's own sensors.
//!
//! [`World::tick`] advances by one control tick (2 ms) under one tick's commands; [`World::readings`] and
//! [`World::tactile`] are what the robot's electronics then report. Reality differs from the nominal numbers by a
//! [`Mismatch`]; the controller and the mental model never see it. The true pose of the object is for reports only.
//!
//! * [`scene`]: what stands where. [`rolling`]: what keeps round things from rolling on. [`model`]: URDF and TOML. [`robot`]: the multibody. [`drive`], [`hand`]: motors, worms, TorqueSwitch, shafts.
//! * [`integrator`]: why a swinging arm keeps its energy.
//! * [`contacts`], [`tactile`], [`sensors`]: what the robot feels. [`mismatch`], [`noise`]: how reality differs.
//! * [`view`]: what stands where, for pictures.
//!
//! Every run is a pure function of scene, mismatch, seed and commands: one thread, `enhanced-determinism`, `libm`.

pub mod contacts;
pub mod digest;
pub mod drive;
pub mod error;
pub mod hand;
pub mod integrator;
pub mod mismatch;
pub mod model;
pub mod noise;
pub mod robot;
pub mod rolling;
pub mod scene;
pub mod sensors;
pub mod tactile;
#[cfg(test)]
mod tests;
pub mod view;

pub use error::WorldError;
pub use hand::HandStart;
pub use mismatch::Mismatch;
pub use scene::{Scene, Standing};

use digest::Fnv;
use hand::{HandDrives, HandParams};
use integrator::Midpoint;
use model::RobotModel;
use nalgebra::Isometry3;
use noise::Noise;
use rapier3d::prelude::*;
use robot::{Robot, Root};
use rolling::Rolling;
use scene::{Inserted, Named};
use sensors::Sensors;
use std::collections::VecDeque;
use tactile::{PadParams, Pads};
use tactus_common::limits::{HAND_LINKS, PAD_CELLS, PADS, TICK_S};
use tactus_common::reading::{HandCommand, JointCommands, JointReadings, TactileImage};
use tactus_common::robot::world_from_base;

/// Physics steps in one tick: 4 of 0.5 ms (see the energy test for what that costs in accuracy).
pub const STEPS_PER_TICK: u32 = 4;

/// Force on a link at which the ideal contact sensor says "touched", newtons.
pub const LINK_CONTACT_N: f32 = 0.1;

/// The settings of rapier that suit a hand on small objects at a step of `dt_s`.
pub fn integration_parameters(dt_s: f32) -> IntegrationParameters {
    let softness = SpringCoefficients::new(1.0 / (8.0 * dt_s), 1.0);
    IntegrationParameters {
        dt: dt_s,
        num_solver_iterations: 1,
        num_internal_pgs_iterations: 2,
        contact_softness: softness,
        static_contact_softness: softness,
        normalized_prediction_distance: 0.002,
        normalized_allowed_linear_error: 0.0005,
        contact_recycling: false,
        contact_clustering: false,
        friction_in_bias_pass: false,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}

/// Everything that changes and is not rapier's: with the physics' bytes, a whole snapshot.
#[derive(Clone, Debug)]
struct State {
    tick: u32,
    drives: HandDrives,
    midpoint: Midpoint,
    pending: VecDeque<JointCommands>,
    noise: Noise,
    readings: JointReadings,
    image: Option<TactileImage>,
    link_force_n: [f32; HAND_LINKS],
}

/// A frozen world; only the world that made it can take it back.
#[derive(Clone, Debug)]
pub struct Snapshot {
    physics: Vec<u8>,
    state: State,
}

/// The world.
pub struct World {
    physics: PhysicsWorld,
    robot: Robot,
    object: RigidBodyHandle,
    /// The other bodies that stand free, and where they stood at first.
    others: Vec<(RigidBodyHandle, Vector)>,
    rolling: Rolling,
    table: ColliderHandle,
    params: HandParams,
    pad_params: [PadParams; PADS],
    arm_effort_nm: [f32; 7],
    pads: Pads,
    sensors: Sensors,
    latency_ticks: u32,
    half_extents_m: [f32; 3],
    state: State,
}

impl World {
    /// Builds the world of `scene` as `mismatch` makes it; `seed` drives the sensors' noise.
    ///
    /// # Errors
    /// [`WorldError::Interpenetration`] if anything overlaps at the start, [`WorldError::Scene`] for numbers that make
    /// no sense, [`WorldError::Model`] if the robot description cannot be used.
    pub fn new(scene: &Scene, mismatch: &Mismatch, seed: u64) -> Result<Self, WorldError> {
        Self::with_model(&RobotModel::shipped()?, scene, mismatch, seed)
    }

    /// [`World::new`] with another robot description.
    ///
    /// # Errors
    /// As [`World::new`].
    pub fn with_model(model: &RobotModel, scene: &Scene, mismatch: &Mismatch, seed: u64) -> Result<Self, WorldError> {
        scene.check(model)?;
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, -9.81);
        physics.integration_parameters = integration_parameters(TICK_S / STEPS_PER_TICK as f32);
        let table = scene::insert_table(&mut physics, scene, mismatch);
        let mut rolling = Rolling::default();
        let object = scene::insert_object(&mut physics, &mut rolling, scene, mismatch)?;
        let friction = robot::Friction { pads: scene.pad_friction * mismatch.pad_friction, bare: scene.bare_friction };
        let root = Root::Arm(world_from_base(&scene.robot_base).into());
        let robot = Robot::insert(&mut physics, model, &mismatch.robot, friction, root)?;
        let params = HandParams::new(model, &mismatch.breakaway);
        let drives = HandDrives::start(&mut physics, &robot, &params, &scene.hand_start, &scene.arm_start_rad);
        let others = insert_others(&mut physics, &mut rolling, scene, mismatch)?;
        let table_and_object = [
            Named { name: "table", collider: table, is_fixed: true },
            Named { name: "object", collider: object.collider, is_fixed: false },
        ];
        let besides = scene.others.iter().zip(&others).map(|(standing, other)| Named {
            name: &standing.name,
            collider: other.collider,
            is_fixed: standing.free_kg.is_none(),
        });
        let named: Vec<Named<'_>> = table_and_object.into_iter().chain(besides).collect();
        scene::check_overlaps(&physics, &robot, model, &named)?;
        let sensors = Sensors::new(model, mismatch)
            .ok_or_else(|| WorldError::Model("`motor_from_joint` cannot be inverted".into()))?;
        let tactile = &model.extra.tactile;
        let pad_params = core::array::from_fn(|pad| PadParams {
            noise_n_cm2: mismatch.tactile_noise_n_cm2,
            threshold_n_cm2: mismatch.tactile_threshold_n_cm2,
            gain: mismatch.tactile_gain[pad],
            step_n_cm2: tactile.step_n_cm2,
            full_scale_n_cm2: tactile.full_scale_n_cm2,
        });
        let mut arm_effort_nm = [0.0; 7];
        for (effort, name) in arm_effort_nm.iter_mut().zip(&model.extra.arm.joints) {
            *effort = model.joint(name)?.effort_nm;
        }
        let mut noise = Noise::new(seed);
        let readings = sensors.read(0, &scene.arm_start_rad, &drives, &[0.0; 3], &[0.0; 4], &mut noise);
        let state = State {
            tick: 0,
            drives,
            midpoint: Midpoint::default(),
            pending: VecDeque::new(),
            noise,
            readings,
            image: None,
            link_force_n: [0.0; HAND_LINKS],
        };
        let pads = Pads::new(tactile);
        let free = scene.others.iter().zip(&others).filter(|(standing, _)| standing.free_kg.is_some());
        let others = free.map(|(_, other)| (other.body, place(&physics, other.body))).collect();
        Ok(Self {
            physics,
            robot,
            object: object.body,
            others,
            rolling,
            table,
            params,
            pad_params,
            arm_effort_nm,
            pads,
            sensors,
            latency_ticks: mismatch.latency_ticks,
            half_extents_m: object.half_extents_m,
            state,
        })
    }

    /// Advances by one tick. `commands` answer the readings of the present tick and act from now on, or from
    /// `latency_ticks` later if the mismatch says so.
    ///
    /// # Errors
    /// [`WorldError::Command`] for a command that is not finite, [`WorldError::NonFinite`] if the simulation diverged.
    pub fn tick(&mut self, commands: &JointCommands) -> Result<(), WorldError> {
        let tick = self.state.tick;
        check_commands(commands, tick)?;
        self.state.pending.push_back(*commands);
        let acting = if self.state.pending.len() as u32 > self.latency_ticks {
            self.state.pending.pop_front().unwrap_or(*commands)
        } else {
            JointCommands::idle(tick)
        };
        let mut tau_nm = acting.arm_tau_nm;
        for (tau, limit) in tau_nm.iter_mut().zip(&self.arm_effort_nm) {
            *tau = tau.clamp(-limit, *limit);
        }
        let dt_s = self.physics.integration_parameters.dt;
        let share = 1.0 / STEPS_PER_TICK as f32;
        let due = Pads::due(tick + 1);
        let mut pressure = [0.0; PAD_CELLS];
        let mut link_force_n = [0.0; HAND_LINKS];
        let mut tip_torque_nm = [0.0; 3];
        let mut effort_nm = [0.0; 4];
        self.robot.arm_limits_in_reach(&mut self.physics);
        for _ in 0..STEPS_PER_TICK {
            self.step(&tau_nm, &acting.hand);
            contacts::hand_contacts(&self.physics, &self.robot, dt_s, |contact| {
                link_force_n[contact.link] += share * contact.force_n();
                if let Some(pad) = due.filter(|pad| PAD_LINKS[*pad] == contact.link) {
                    contact.along_the_patch(|part| {
                        let force_n = part.force_n * share;
                        self.pads.press(pad, &tactile::LinkForce { force_n, ..*part }, &mut pressure);
                    });
                }
            });
            for f in 0..3 {
                tip_torque_nm[f] += share * self.state.drives.fingers[f].cable_nm;
                effort_nm[f] += share * self.state.drives.fingers[f].motor.effort_nm;
            }
            effort_nm[3] += share * self.state.drives.spread.effort_nm;
        }
        let arm: [drive::JointState; 7] = self.robot.states(&self.physics, &self.robot.arm);
        let arm_q_rad = arm.map(|s| s.q_rad);
        let tick = tick + 1;
        self.check_finite(tick)?;
        let state = &mut self.state;
        state.tick = tick;
        state.link_force_n = link_force_n;
        state.image = due.map(|pad| Pads::read(pad, tick, &pressure, &self.pad_params[pad], &mut state.noise));
        state.readings =
            self.sensors.read(tick, &arm_q_rad, &state.drives, &tip_torque_nm, &effort_nm, &mut state.noise);
        Ok(())
    }

    fn step(&mut self, tau_nm: &[f32; 7], hand: &[HandCommand; 4]) {
        let dt_s = self.physics.integration_parameters.dt;
        self.state.drives.drive(&mut self.physics, &self.robot, &self.params, hand, dt_s);
        self.step_arm(tau_nm);
        self.state.drives.feel(&self.physics, &self.robot, &self.params);
    }

    fn step_arm(&mut self, tau_nm: &[f32; 7]) {
        let arm: [drive::JointState; 7] = self.robot.states(&self.physics, &self.robot.arm);
        let (q_rad, qd_rad_s) = (arm.map(|s| s.q_rad), arm.map(|s| s.qd_rad_s));
        let correction = self.state.midpoint.torques(&q_rad, &qd_rad_s);
        let tau_nm = core::array::from_fn(|i| tau_nm[i] + correction[i]);
        self.robot.set_arm_torques(&mut self.physics, &q_rad, &tau_nm);
        self.rolling.resist(&mut self.physics);
        self.physics.step();
    }

    /// Takes limits and collisions away from the robot (physics tests).
    #[cfg(test)]
    fn free_the_arm(&mut self) {
        self.robot.make_frictionless(&mut self.physics, false);
        self.robot.remove_all_damping(&mut self.physics);
        self.robot.remove_limits(&mut self.physics);
        let hand = self.robot.spread.iter().chain(&self.robot.inner).chain(&self.robot.tip);
        let springs: Vec<_> = hand.map(|j| (*j, 1e5, self.robot.state(&self.physics, j).q_rad)).collect();
        self.robot.set_springs(&mut self.physics, &springs);
        for named in &self.robot.colliders {
            if let Some(collider) = self.physics.colliders.get_mut(named.collider) {
                collider.set_collision_groups(InteractionGroups::none());
            }
        }
    }

    /// Takes the table away (physics tests).
    #[cfg(test)]
    fn remove_table(&mut self) {
        self.physics.remove_collider(self.table);
    }

    fn check_finite(&self, tick: u32) -> Result<(), WorldError> {
        let failed = |body: &str| Err(WorldError::NonFinite { body: body.to_owned(), tick });
        let finite = |handle: RigidBodyHandle| {
            self.physics.bodies.get(handle).is_some_and(|b| {
                b.is_enabled() && b.position().is_finite() && b.linvel().is_finite() && b.angvel().is_finite()
            })
        };
        if !finite(self.object) {
            return failed("object");
        }
        if !self.others.iter().all(|(other, _)| finite(*other)) {
            return failed("another object");
        }
        for (index, link) in self.robot.hand_links.iter().enumerate() {
            if !finite(link.body) {
                return failed(HAND_LINK_NAMES[index]);
            }
        }
        Ok(())
    }

    /// The present tick: how many have passed.
    pub fn now(&self) -> u32 {
        self.state.tick
    }

    /// Joint readings of the present tick.
    pub fn readings(&self) -> JointReadings {
        self.state.readings
    }

    /// The image of the pad that was scanned at the present tick, if any (every third tick one of the four).
    pub fn tactile(&self) -> Option<TactileImage> {
        self.state.image
    }

    /// Ideal contact sensor of the method's own study, which the real hand lacks: bit i = hand link i is touched
    /// with at least [`LINK_CONTACT_N`] (contact-matrix order).
    pub fn link_contacts(&self) -> u16 {
        let touched =
            |bits: u16, (i, force): (usize, &f32)| if *force >= LINK_CONTACT_N { bits | 1 << i } else { bits };
        self.state.link_force_n.iter().enumerate().fold(0, touched)
    }

    /// Normal force on each hand link over the last tick, newtons (truth, for reports and tests).
    pub fn link_forces_n(&self) -> [f32; HAND_LINKS] {
        self.state.link_force_n
    }

    /// True pose of the object's frame (its centroid) in the world, for reports only.
    pub fn object_pose(&self) -> Isometry3<f32> {
        self.physics.bodies.get(self.object).map_or_else(Isometry3::identity, |b| (*b.position()).into())
    }

    /// The farthest that any other free body is from where it stood at first, metres, for reports only.
    pub fn others_shift_m(&self) -> f32 {
        let shift_m = |(body, from): &(RigidBodyHandle, Vector)| (place(&self.physics, *body) - *from).length();
        self.others.iter().map(shift_m).fold(0.0, f32::max)
    }

    /// True half extents of the object, metres, for reports only.
    pub fn object_half_extents_m(&self) -> [f32; 3] {
        self.half_extents_m
    }

    /// True arm joint angles, radians, for reports only.
    pub fn arm_q_rad(&self) -> [f32; 7] {
        let states: [drive::JointState; 7] = self.robot.states(&self.physics, &self.robot.arm);
        states.map(|s| s.q_rad)
    }

    /// True pose of the hand frame in the world, for reports and the viewer.
    pub fn hand_pose(&self) -> Isometry3<f32> {
        self.robot.hand_link_pose(&self.physics, 0).into()
    }

    /// True poses of the nine hand links' frames in the world, for reports and the viewer.
    pub fn hand_link_poses(&self) -> [Isometry3<f32>; HAND_LINKS] {
        core::array::from_fn(|i| self.robot.hand_link_pose(&self.physics, i).into())
    }

    /// Freezes the world, for a rollout that branches off here.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`] if rapier's state cannot be written.
    pub fn snapshot(&self) -> Result<Snapshot, WorldError> {
        let physics = postcard::to_stdvec(&self.physics).map_err(|e| WorldError::Snapshot(e.to_string()))?;
        Ok(Snapshot { physics, state: self.state.clone() })
    }

    /// Goes back to a snapshot of this world; what follows is bit for bit what followed then.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`] if the bytes do not fit; the world is then unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), WorldError> {
        self.physics = postcard::from_bytes(&snapshot.physics).map_err(|e| WorldError::Snapshot(e.to_string()))?;
        self.state = snapshot.state.clone();
        Ok(())
    }

    /// Digest of everything that determines the future: poses, velocities, drives, noise.
    pub fn state_digest(&self) -> u64 {
        let mut fnv = Fnv::default();
        fnv.u32(self.state.tick);
        for (_, body) in self.physics.bodies.iter() {
            fnv.f32s(&body.translation().to_array());
            fnv.f32s(&body.rotation().to_array());
            fnv.f32s(&body.linvel().to_array());
            fnv.f32s(&body.angvel().to_array());
        }
        for finger in &self.state.drives.fingers {
            fnv.f32s(&[finger.motor.q_rad, finger.motor.qd_rad_s, finger.clutch_nm, finger.cable_nm]);
            fnv.f32(finger.broken_at_rad.unwrap_or(-1.0));
        }
        fnv.f32s(&[self.state.drives.spread.q_rad, self.state.drives.spread.qd_rad_s]);
        fnv.f32s(&self.state.midpoint.before_rad_s);
        fnv.f32s(&self.state.midpoint.change_rad_s);
        fnv.u32(self.state.noise.fingerprint());
        fnv.value()
    }
}

/// Inserts what stands beside the object.
fn insert_others(
    physics: &mut PhysicsWorld,
    rolling: &mut Rolling,
    scene: &Scene,
    mismatch: &Mismatch,
) -> Result<Vec<Inserted>, WorldError> {
    scene.others.iter().map(|other| scene::insert_other(physics, rolling, scene, mismatch, other)).collect()
}

/// Where a body is.
fn place(physics: &PhysicsWorld, body: RigidBodyHandle) -> Vector {
    physics.bodies.get(body).map_or(Vector::ZERO, |b| b.position().translation)
}

/// The hand link that carries each pad, contact-matrix index.
pub const PAD_LINKS: [usize; PADS] = [3, 6, 8, 0];

/// Names of the hand links in contact-matrix order.
pub const HAND_LINK_NAMES: [&str; HAND_LINKS] =
    ["palm", "F1 knuckle", "F1 inner", "F1 tip", "F2 knuckle", "F2 inner", "F2 tip", "F3 inner", "F3 tip"];

fn check_commands(commands: &JointCommands, tick: u32) -> Result<(), WorldError> {
    if !commands.arm_tau_nm.iter().all(|tau| tau.is_finite()) {
        return Err(WorldError::Command { drive: "the arm", tick });
    }
    for command in &commands.hand {
        let value = match command {
            HandCommand::Idle => 0.0,
            HandCommand::Position(v) | HandCommand::Velocity(v) | HandCommand::Torque(v) => *v,
        };
        if !value.is_finite() {
            return Err(WorldError::Command { drive: "the hand", tick });
        }
    }
    Ok(())
}
