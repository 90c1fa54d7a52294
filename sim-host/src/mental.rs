//! The mental world: what the hand would feel if the object stood at a hypothesised pose.
//!
//! A world of its own, built from nominal numbers only: the palm fixed where the arm holds it, the fingers' drives, a
//! nominal table, object and obstacles. It shares nothing with the real [`crate::world::World`] but the description of the robot.

use crate::world::contacts::hand_contacts;
use crate::world::hand::{HandDrives, HandParams, HandStart};
use crate::world::model::RobotModel;
use crate::world::robot::{Friction, Robot, Root};
use crate::world::rolling::Rolling;
use crate::world::{LINK_CONTACT_N, Mismatch, Scene, Standing, WorldError, integration_parameters, scene};
use nalgebra::Isometry3;
use rapier3d::parry::query;
use rapier3d::prelude::*;
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_LINKS, TICK_S};
use tactus_common::message::ROLLOUT_INSTANTS;
use tactus_common::pose::PlanarPose;
use tactus_common::reading::HandCommand;
use tactus_common::robot::{MOUNT, arm};
use tactus_common::shape::{ObjectShape, Obstacle};

/// Physics steps in one tick of the mental world; coarser than reality, as only contacts at low speed matter.
pub const STEPS_PER_TICK: u32 = 2;

/// Overlap at the start beyond which a link counts as in contact before it moves, metres.
const OVERLAP_M: f32 = 5e-4;

/// Hand links of each finger, contact-matrix indices (F3's knuckle is the palm).
pub const FINGER_LINKS: [&[usize]; FINGERS] = [&[1, 2, 3], &[4, 5, 6], &[7, 8]];

/// How the fingers close.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closing {
    /// All at once.
    Together,
    /// One after the other, in this order; the next starts when the one before has stopped.
    InTurn([u8; FINGERS]),
}

/// One touch to roll out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RolloutInput {
    /// Pose of the hand frame, held by the arm.
    pub world_from_hand: Isometry3<f32>,
    /// Preopen inner angles and spread, radians.
    pub start: HandStart,
    /// Order of closing.
    pub closing: Closing,
    /// Closing speed of each finger's inner link, rad/s.
    pub speed_rad_s: [f32; FINGERS],
    /// A finger stops here at the latest, radians.
    pub stop_at_rad: f32,
    /// Ticks to simulate (0.6 s = 300); ends earlier when every finger has stopped.
    pub ticks: u32,
    /// Where the object is thought to stand.
    pub object: PlanarPose,
    /// Its shape.
    pub shape: ObjectShape,
}

/// One tick of a rollout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RolloutSample {
    /// Bit i: hand link i (contact-matrix order) is touched.
    pub contacts: u16,
    /// Inner joint angles, radians.
    pub inner_rad: [f32; FINGERS],
    /// Distal joint angles, radians.
    pub distal_rad: [f32; FINGERS],
}

/// What a rollout foretells.
#[derive(Clone, Debug, PartialEq)]
pub struct RolloutOutcome {
    /// Inner angle of each finger at its first contact; `None` = it touched nothing.
    pub onset_rad: [Option<f32>; FINGERS],
    /// Tick of each first contact.
    pub onset_tick: [Option<u32>; FINGERS],
    /// Links that overlap the object or the table before anything moves: this pose is hardly possible. They take no part.
    pub overlapping: u16,
    /// Tick by tick.
    pub samples: Vec<RolloutSample>,
    /// How far the object was shifted, metres.
    pub object_shift_m: f32,
}

impl RolloutOutcome {
    /// Hand links that have touched so far, at equally spaced instants of `ticks` ticks. A link that has touched once
    /// counts as touching, since its finger stands still from then on, even if the force sinks below what the sensor
    /// notices; a rollout that ends early stays as it ended.
    pub fn touched_by_instant(&self, ticks: usize) -> [u16; ROLLOUT_INSTANTS] {
        let (mut samples, mut touched, mut taken) = (self.samples.iter(), 0, 0);
        std::array::from_fn(|i| {
            let until = (i + 1) * ticks / ROLLOUT_INSTANTS;
            touched = samples.by_ref().take(until - taken).fold(touched, |bits, sample| bits | sample.contacts);
            taken = until;
            touched
        })
    }
}

/// The robot, read once, and the numbers of the world that it acts in.
pub struct MentalModel {
    model: RobotModel,
    params: HandParams,
    numbers: Mismatch,
    obstacles: Vec<Standing>,
    robot_base: PlanarPose,
}

impl MentalModel {
    /// The shipped robot with nominal numbers.
    ///
    /// # Errors
    /// [`WorldError::Model`] if the description cannot be used.
    pub fn new() -> Result<Self, WorldError> {
        Self::of(&Mismatch::none())
    }

    /// The shipped robot and a world of these numbers: for experiments that ask for a trial of the held hand in reality
    /// at every evaluation. No controller's mental world has other than nominal numbers.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(numbers: &Mismatch) -> Result<Self, WorldError> {
        let model = RobotModel::shipped()?;
        let params = HandParams::new(&model, &numbers.breakaway);
        Ok(Self { model, params, numbers: *numbers, obstacles: Vec::new(), robot_base: MOUNT })
    }

    /// The same world with these obstacles on its table. They do not move there, whatever they do in reality.
    pub fn among(self, obstacles: &[Obstacle]) -> Self {
        let standing = |(index, obstacle): (usize, &Obstacle)| Standing {
            name: format!("obstacle {}", index + 1),
            shape: obstacle.shape,
            pose: obstacle.pose,
            free_kg: None,
        };
        Self { obstacles: obstacles.iter().enumerate().map(standing).collect(), ..self }
    }

    /// The same world with the robot's base standing at `robot_base`.
    pub fn with_robot_at(self, robot_base: &PlanarPose) -> Self {
        Self { robot_base: *robot_base, ..self }
    }

    /// World-from-hand pose at these joint angles of the arm, radians.
    pub fn hand_pose(&self, arm_q_rad: &[f32; ARM_JOINTS]) -> Isometry3<f32> {
        arm::hand_pose_from(&self.robot_base, arm_q_rad)
    }

    /// Rolls one touch out.
    ///
    /// # Errors
    /// [`WorldError::Scene`] for a pose off the table or angles beyond their limits, [`WorldError::NonFinite`] if it diverges.
    pub fn rollout(&self, input: &RolloutInput) -> Result<RolloutOutcome, WorldError> {
        Rollout::new(self, input)?.run(input)
    }
}

struct Rollout<'a> {
    physics: PhysicsWorld,
    robot: Robot,
    params: &'a HandParams,
    drives: HandDrives,
    rolling: Rolling,
    object: RigidBodyHandle,
    overlapping: u16,
}

impl<'a> Rollout<'a> {
    fn new(mental: &'a MentalModel, input: &RolloutInput) -> Result<Self, WorldError> {
        let numbers = &mental.numbers;
        let scene = Scene {
            object: input.object,
            shape: input.shape,
            others: mental.obstacles.clone(),
            hand_start: input.start,
            ..Scene::default()
        };
        scene.check(&mental.model)?;
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, -9.81);
        physics.integration_parameters = integration_parameters(TICK_S / STEPS_PER_TICK as f32);
        let table = scene::insert_table(&mut physics, &scene, numbers);
        let mut rolling = Rolling::default();
        let object = scene::insert_object(&mut physics, &mut rolling, &scene, numbers)?;
        let friction = Friction { pads: scene.pad_friction * numbers.pad_friction, bare: scene.bare_friction };
        let root = Root::Hand(input.world_from_hand.into());
        let robot = Robot::insert(&mut physics, &mental.model, &numbers.robot, friction, root)?;
        let params = &mental.params;
        let drives = HandDrives::start(&mut physics, &robot, params, &input.start, &[]);
        let mut touchable = vec![table, object.collider];
        for other in &scene.others {
            let other = scene::insert_other(&mut physics, &mut rolling, &scene, numbers, other)?;
            // A hypothesis may have the object within an obstacle, which would throw it out: the hypothesis comes first.
            if depth_m(&physics, other.collider, object.collider) > OVERLAP_M {
                physics.remove_body(other.body);
            } else {
                touchable.push(other.collider);
            }
        }
        let mut overlapping = 0;
        for (i, link) in robot.hand_links.iter().enumerate() {
            let deep = touchable.iter().any(|other| depth_m(&physics, link.collider, *other) > OVERLAP_M);
            if deep {
                overlapping |= 1 << i;
                if let Some(collider) = physics.colliders.get_mut(link.collider) {
                    collider.set_collision_groups(InteractionGroups::none());
                }
            }
        }
        Ok(Self { physics, robot, params, drives, rolling, object: object.body, overlapping })
    }

    fn run(mut self, input: &RolloutInput) -> Result<RolloutOutcome, WorldError> {
        let dt_s = self.physics.integration_parameters.dt;
        let before = self.object_at();
        let mut outcome = RolloutOutcome {
            onset_rad: [None; FINGERS],
            onset_tick: [None; FINGERS],
            overlapping: self.overlapping,
            samples: Vec::with_capacity(input.ticks as usize),
            object_shift_m: 0.0,
        };
        let mut stopped = [false; FINGERS];
        for tick in 0..input.ticks {
            let mut force_n = [0.0_f32; HAND_LINKS];
            let commands = commands(input, &stopped);
            self.robot.arm_limits_in_reach(&mut self.physics);
            for _ in 0..STEPS_PER_TICK {
                self.drives.drive(&mut self.physics, &self.robot, self.params, &commands, dt_s);
                self.rolling.resist(&mut self.physics);
                self.physics.step();
                self.drives.feel(&self.physics, &self.robot, self.params);
                hand_contacts(&self.physics, &self.robot, dt_s, |contact| {
                    force_n[contact.link] += contact.force_n() / STEPS_PER_TICK as f32;
                });
            }
            let mut contacts = self.overlapping;
            for (i, force) in force_n.iter().enumerate() {
                contacts |= u16::from(*force >= LINK_CONTACT_N) << i;
            }
            for f in 0..FINGERS {
                let inner_rad = self.drives.inner[f].q_rad;
                if !inner_rad.is_finite() {
                    return Err(WorldError::NonFinite { body: format!("mental finger {}", f + 1), tick });
                }
                let touched = FINGER_LINKS[f].iter().any(|link| contacts & (1 << link) != 0);
                if touched && outcome.onset_tick[f].is_none() {
                    outcome.onset_tick[f] = Some(tick);
                    outcome.onset_rad[f] = Some(inner_rad);
                }
                stopped[f] |= touched || self.drives.fingers[f].motor.q_rad >= input.stop_at_rad;
            }
            outcome.samples.push(RolloutSample {
                contacts,
                inner_rad: self.drives.inner.map(|j| j.q_rad),
                distal_rad: self.drives.distal.map(|j| j.q_rad),
            });
            if stopped == [true; FINGERS] {
                break;
            }
        }
        outcome.object_shift_m = (self.object_at() - before).length();
        Ok(outcome)
    }

    fn object_at(&self) -> Vector {
        self.physics.bodies.get(self.object).map_or(Vector::ZERO, |b| b.position().translation)
    }
}

/// A finger closes until it has stopped; in turn, only the first that has not.
fn commands(input: &RolloutInput, stopped: &[bool; FINGERS]) -> [HandCommand; 4] {
    let mut commands = [HandCommand::Velocity(0.0); 4];
    match input.closing {
        Closing::Together => {
            for f in 0..FINGERS {
                if !stopped[f] {
                    commands[f] = HandCommand::Velocity(input.speed_rad_s[f]);
                }
            }
        }
        Closing::InTurn(order) => {
            let next = order.iter().map(|f| *f as usize).find(|f| stopped.get(*f) == Some(&false));
            if let Some(f) = next {
                commands[f] = HandCommand::Velocity(input.speed_rad_s[f]);
            }
        }
    }
    commands
}

fn depth_m(physics: &PhysicsWorld, a: ColliderHandle, b: ColliderHandle) -> f32 {
    let (Some(a), Some(b)) = (physics.colliders.get(a), physics.colliders.get(b)) else { return 0.0 };
    let found = query::contact(a.position(), a.shape(), b.position(), b.shape(), 0.0);
    found.ok().flatten().map_or(0.0, |contact| -contact.dist)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    /// The hand straight down over the box, its fingers across the 0.1 m depth, palm 46 mm above the top.
    pub(crate) fn over_the_box(object: PlanarPose) -> RolloutInput {
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f32::consts::PI);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f32::consts::FRAC_PI_2);
        RolloutInput {
            world_from_hand: Isometry3::from_parts(Translation3::new(0.2, -0.1, 0.325), turn * down),
            start: HandStart { inner_rad: [0.7; 3], spread_rad: 0.0 },
            closing: Closing::Together,
            speed_rad_s: [0.8; 3],
            stop_at_rad: 1.6,
            ticks: 300,
            object,
            shape: ObjectShape::THESIS_BOX,
        }
    }

    #[test]
    fn fingers_meet_a_centred_box_alike_and_a_shifted_one_earlier_on_its_side() {
        let mental = MentalModel::new().unwrap();
        let centred = mental.rollout(&over_the_box(PlanarPose::new(0.2, -0.1, 0.0))).unwrap();
        assert_eq!(centred.overlapping, 0);
        let onset = centred.onset_rad.map(|q| q.unwrap());
        assert!((onset[0] - onset[1]).abs() < 2e-3 && (onset[0] - onset[2]).abs() < 5e-3, "{onset:?}");
        assert!(centred.object_shift_m < 1e-3, "{} m", centred.object_shift_m);
        let last = centred.samples.last().unwrap();
        assert_eq!(last.contacts & 0b1_0100_1000, 0b1_0100_1000, "all tips touch: {:b}", last.contacts);
        // Moved by 10 mm along the closing direction: one side meets it earlier, the other later.
        let shifted = mental.rollout(&over_the_box(PlanarPose::new(0.2, -0.09, 0.0))).unwrap();
        let (a, b) = (shifted.onset_rad[0].unwrap() - onset[0], shifted.onset_rad[2].unwrap() - onset[2]);
        assert!(a * b < 0.0 && a.abs() > 0.05 && b.abs() > 0.05, "{a} {b}");
    }

    #[test]
    fn in_turn_only_one_finger_moves_at_a_time() {
        let mental = MentalModel::new().unwrap();
        let input = RolloutInput {
            closing: Closing::InTurn([2, 0, 1]),
            ticks: 900,
            speed_rad_s: [1.0; 3],
            ..over_the_box(PlanarPose::new(0.2, -0.1, 0.0))
        };
        let outcome = mental.rollout(&input).unwrap();
        let at = outcome.onset_tick.map(|t| t.unwrap());
        assert!(at[2] < at[0] && at[0] < at[1], "{at:?}");
        let early = outcome.samples[at[2] as usize / 2];
        assert!((early.inner_rad[0] - 0.7).abs() < 5e-3 && early.inner_rad[2] > 0.72, "{early:?}");
    }

    #[test]
    fn a_pose_inside_the_hand_is_told_and_does_not_explode() {
        let mental = MentalModel::new().unwrap();
        let outcome = mental.rollout(&over_the_box(PlanarPose::new(0.2, -0.02, 0.0))).unwrap();
        assert_ne!(outcome.overlapping, 0);
        assert!(outcome.object_shift_m < 0.01, "{}", outcome.object_shift_m);
    }

    #[test]
    fn an_obstacle_is_felt_as_an_object_of_its_shape_would_be() {
        let box_at = PlanarPose::new(0.2, -0.1, 0.0);
        let aside = RolloutInput { object: PlanarPose::new(-0.4, 0.1, 0.0), ..over_the_box(box_at) };
        let obstacle = Obstacle { shape: ObjectShape::THESIS_BOX, pose: box_at };
        let alone = MentalModel::new().unwrap();
        assert_eq!(alone.rollout(&aside).unwrap().onset_rad, [None; FINGERS], "nothing is there");
        let felt = alone.rollout(&over_the_box(box_at)).unwrap().onset_rad.map(|q| q.unwrap());
        let among = MentalModel::new().unwrap().among(&[obstacle]);
        let met = among.rollout(&aside).unwrap().onset_rad.map(|q| q.unwrap());
        assert!(felt.iter().zip(&met).all(|(a, b)| (a - b).abs() < 5e-3), "{felt:?} {met:?}");
        // A hypothesis with the object within the obstacle is rolled out as if that were not there.
        let within = among.rollout(&over_the_box(box_at)).unwrap();
        assert!(within.object_shift_m < 1e-3, "{} m", within.object_shift_m);
    }

    #[test]
    fn two_rollouts_of_the_same_input_are_the_same() {
        let mental = MentalModel::new().unwrap();
        let input = over_the_box(PlanarPose::new(0.21, -0.105, 0.1));
        assert_eq!(mental.rollout(&input).unwrap(), mental.rollout(&input).unwrap());
    }
}
