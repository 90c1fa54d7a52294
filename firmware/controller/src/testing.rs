//! A bench for tests: an arm that stands at its reference, a hand that closes on a box, a planner that knows no
//! obstacles and a mental world that closes the same fingers. As simple as can be, so that it is plain what it promises.

extern crate std;

use crate::controller::Outputs;
use crate::executor::Executor;
use crate::mission::Tools;
use crate::onset::{Felt, Onset};
use core::f32::consts::PI;
use nalgebra::{Isometry3, SMatrix, SVector, Translation3, UnitQuaternion, Vector3};
use std::vec::Vec;
use tactus_common::limits::{
    ARM_ACCELERATION_MAX_RAD_S2, ARM_JOINTS, FINGERS, HAND_MOTORS, OBSTACLES_MAX, PAD_CELLS, PADS, TICK_S,
};
use tactus_common::message::{
    PlanAnswer, PlanRequest, Purpose, ROLLOUT_INSTANTS, RefusalReason, RolloutRequest, RolloutResult, SCHEMA_VERSION,
    Setup,
};
use tactus_common::method::Method;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{HandCommand, JointReadings, TactileImage, Validity};
use tactus_common::robot::hand::{self, HandAngles};
use tactus_common::robot::tables::{FINGER_LIMIT, SPREAD_LIMIT};
use tactus_common::robot::{ARM_LIMITS, HandLink, MOUNT, arm, dynamics, hand_prism, inverse};
use tactus_common::shape::ObjectShape;
use tactus_common::trajectory::{Knot, Trajectory};

/// Joint angles.
pub type Joints = [f32; ARM_JOINTS];

/// The box of the tests.
pub const BOX: ObjectShape = ObjectShape::THESIS_BOX;
/// Where it stands.
pub const TRUTH: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.05 };
/// Speed of a finger that moves to a position or pushes, rad/s.
const DRIVE_RAD_S: f32 = 2.0;
/// A finger feels what it would touch this much further, radians; more than it closes in a tick.
const PROBE_RAD: f32 = 1e-3;
/// A link this near touches, metres: fingers stop that much before the object.
const TOUCH_M: f32 = 4e-4;
/// Torque of a fingertip that touches, Nm.
const TOUCH_NM: f32 = 0.2;

/// A mission that makes sense: the guess is 10 mm, 8 mm and 0.05 rad off.
pub fn setup() -> Setup {
    Setup {
        schema_version: SCHEMA_VERSION.to_le_bytes(),
        shape: BOX,
        guess: PlanarPose::new(0.21, -0.108, 0.0),
        interval: Interval { x_m: 0.02, y_m: 0.02, phi_rad: 0.1 },
        obstacles: [None; OBSTACLES_MAX],
        displacement_m: [-0.5, 0.0],
        mass_kg: 0.6,
        trials_max: 12,
        robot_base: MOUNT,
        method: Method::default(),
    }
}

/// Readings of a robot that stands still at `q_rad`, hand open, nothing touched.
pub fn readings(tick: u32, q_rad: Joints) -> JointReadings {
    JointReadings {
        tick,
        arm_q_rad: q_rad,
        motor_q_rad: [0.0; HAND_MOTORS],
        inner_q_rad: [0.0; FINGERS],
        effort_nm: [0.0; HAND_MOTORS],
        tip_torque_nm: [0.0; FINGERS],
        valid: Validity::ALL,
    }
}

/// Posture with the hand pointing straight down, high above the table.
pub fn home() -> Joints {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    let pose = Isometry3::from_parts(Translation3::new(0.0, -0.1, 0.55), down);
    nearest_posture(&pose, &[0.0; ARM_JOINTS]).expect("well within reach")
}

fn swivels() -> impl Iterator<Item = f32> {
    (-12..=12).map(|k| k as f32 * 0.25)
}

fn farthest(a: &Joints, b: &Joints) -> f32 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

/// The posture for a hand pose that is nearest to another.
fn nearest_posture(pose: &Isometry3<f32>, to: &Joints) -> Option<Joints> {
    swivels()
        .filter_map(|swivel| inverse::solve(pose, swivel).ok())
        .flatten()
        .min_by(|a, b| farthest(a, to).total_cmp(&farthest(b, to)))
}

/// A knot at rest.
pub fn rest(t_s: f32, q_rad: Joints) -> Knot {
    Knot { t_s, q_rad, ..Knot::default() }
}

/// Seconds in which the arm gets from rest to rest within its limits, at least `least_s`: a quintic's peaks are
/// 1.875 d/T and 5.774 d/T^2.
pub fn travel_s(from: &Joints, to: &Joints, least_s: f32) -> f32 {
    let mut t_s = least_s;
    for j in 0..ARM_JOINTS {
        let d = (to[j] - from[j]).abs();
        t_s = t_s.max(1.875 * d / (0.9 * ARM_LIMITS[j].velocity_rad_s));
        t_s = t_s.max(libm::sqrtf(5.774 * d / (0.9 * ARM_ACCELERATION_MAX_RAD_S2[j])));
    }
    t_s
}

/// From rest to rest through postures, each leg at least `least_s` long; the last leg is guarded.
pub fn through(request: u16, postures: &[Joints], least_s: f32) -> Trajectory {
    let mut trajectory = Trajectory { request, knots: Default::default(), guarded_from: 255 };
    let mut t_s = 0.0;
    for (i, q_rad) in postures.iter().enumerate() {
        if i > 0 {
            t_s += travel_s(&postures[i - 1], q_rad, least_s);
        }
        trajectory.knots.push(rest(t_s, *q_rad)).expect("few postures");
    }
    trajectory.guarded_from = postures.len() as u8 - 2;
    trajectory
}

/// The planner: postures above and at the goal, or up, over and down; no obstacles.
pub fn plan(request: &PlanRequest, shape: &ObjectShape) -> Result<Trajectory, RefusalReason> {
    let raised = |pose: &Isometry3<f32>, by_m: f32| Translation3::new(0.0, 0.0, by_m) * pose;
    let start = request.start_q_rad;
    let refusal = RefusalReason::NoInverseKinematics;
    let mut postures = Vec::from([start]);
    match request.purpose {
        Purpose::Touch | Purpose::Grasp => {
            let goal = request.placement.world_from_hand(&request.belief, shape);
            let above = nearest_posture(&raised(&goal, 0.1), &start).ok_or(refusal)?;
            postures.extend([above, nearest_posture(&goal, &above).ok_or(refusal)?]);
        }
        Purpose::Retreat => {
            let above = raised(&arm::hand_pose(&start), 0.1);
            postures.push(nearest_posture(&above, &start).ok_or(refusal)?);
            return Ok(Trajectory { guarded_from: u8::MAX, ..through(request.request, &postures, 0.8) });
        }
        Purpose::Transport => {
            let from = arm::hand_pose(&start);
            let [dx_m, dy_m] = request.displacement_m;
            let to = Translation3::new(dx_m, dy_m, 0.0) * from;
            for pose in [raised(&from, 0.06), raised(&to, 0.06), to] {
                let last = postures[postures.len() - 1];
                postures.push(nearest_posture(&pose, &last).ok_or(refusal)?);
            }
        }
    }
    Ok(through(request.request, &postures, 0.8))
}

/// Which fingers, and whether the palm, cut into the object.
pub fn cuts(world_from_hand: &Isometry3<f32>, angles: &HandAngles, object: &PlanarPose, shape: &ObjectShape) -> Felt {
    let object_from_hand = object.isometry(shape.rest_height_m()).inverse() * world_from_hand;
    let mut felt = Felt::default();
    for (link, pose) in HandLink::ALL.iter().zip(hand::link_poses(&object_from_hand, angles)) {
        let inside = shape.separation_below(&pose, hand_prism(*link), 0.0).is_some_and(|s| s.distance_m < 0.0);
        match link.finger() {
            Some(finger) => felt.fingers[finger] |= inside,
            None => felt.palm |= inside,
        }
    }
    felt
}

/// The mental world: closes the same fingers on the box.
pub fn rollout(request: &RolloutRequest, shape: &ObjectShape, effective: u32) -> RolloutResult {
    let world_from_hand = arm::hand_pose(&request.arm_q_rad);
    let mut onset_inner_rad = [None; FINGERS];
    let mut touched = 0;
    for (finger, onset) in onset_inner_rad.iter_mut().enumerate().filter(|(f, _)| request.closing_rad_s[*f] > 0.0) {
        let mut inner_rad = request.preshape.inner_rad;
        while onset.is_none() && inner_rad[finger] < 1.9 {
            inner_rad[finger] += 0.002;
            let angles = HandAngles::engaged(inner_rad, request.preshape.spread_rad);
            if cuts(&world_from_hand, &angles, &request.pose, shape).fingers[finger] {
                *onset = Some(inner_rad[finger]);
                touched |= 1 << HandLink::TIPS[finger].index();
            }
        }
    }
    // Tips, and at every instant: which link it is matters, when it touches is told by the onset.
    RolloutResult { effective, request: request.request, onset_inner_rad, contacts: [touched; ROLLOUT_INSTANTS] }
}

/// A hand without mass or springs: a finger moves as it is told and stops at the object.
#[derive(Clone, Debug, Default)]
pub struct HandSim {
    /// F1, F2, F3, spread, radians; inner links follow their motors exactly.
    pub motor_q_rad: [f32; HAND_MOTORS],
    /// What touches.
    pub felt: Felt,
}

impl HandSim {
    /// One tick; `object` is what it may run into.
    pub fn step(
        &mut self,
        commands: &[HandCommand; HAND_MOTORS],
        world_from_hand: &Isometry3<f32>,
        object: Option<&PlanarPose>,
    ) {
        for (m, command) in commands.iter().enumerate() {
            let step = DRIVE_RAD_S * TICK_S;
            let change = match command {
                HandCommand::Idle => 0.0,
                HandCommand::Position(target) => (target - self.motor_q_rad[m]).clamp(-step, step),
                HandCommand::Velocity(speed) => speed * TICK_S,
                HandCommand::Torque(torque) => {
                    if *torque > 0.0 {
                        step
                    } else {
                        -step
                    }
                }
            };
            let before = self.motor_q_rad[m];
            let limit = if m < FINGERS { FINGER_LIMIT } else { SPREAD_LIMIT };
            self.motor_q_rad[m] = (before + change).clamp(limit.lower_rad, limit.upper_rad);
            if m < FINGERS && change > 0.0 && self.cuts(0.0, world_from_hand, object).fingers[m] {
                self.motor_q_rad[m] = before;
            }
        }
        self.felt = self.cuts(PROBE_RAD, world_from_hand, object);
    }

    /// What cuts into the object with every finger closed by `further_rad`.
    fn cuts(&self, further_rad: f32, world_from_hand: &Isometry3<f32>, object: Option<&PlanarPose>) -> Felt {
        let [f1, f2, f3, spread] = self.motor_q_rad;
        let angles = HandAngles::engaged([f1, f2, f3].map(|q| q + further_rad), spread);
        object.map_or(Felt::default(), |o| cuts(world_from_hand, &angles, o, &BOX))
    }
}

/// Robot and object: the arm is where it is told to be, the hand runs into the object, and carries it if fingers on
/// both sides push.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Where the arm is.
    pub q_rad: Joints,
    /// The hand.
    pub hand: HandSim,
    /// Where the object stands; `None`: there is none.
    pub object: Option<PlanarPose>,
    /// The object in the hand's frame while it is held.
    held: Option<Isometry3<f32>>,
}

impl Default for Bench {
    fn default() -> Self {
        Self { q_rad: home(), hand: HandSim::default(), object: Some(TRUTH), held: None }
    }
}

impl Bench {
    /// One tick: the arm goes to `q_rad`, the hand does what it is told.
    pub fn step(&mut self, q_rad: &Joints, commands: &[HandCommand; HAND_MOTORS]) {
        self.q_rad = *q_rad;
        let world_from_hand = arm::hand_pose(q_rad);
        let pushes = |f: usize| matches!(commands[f], HandCommand::Torque(t) if t > 0.0) && self.hand.felt.fingers[f];
        let holds = self.object.is_some() && pushes(2) && (pushes(0) || pushes(1));
        match (holds, self.held, self.object) {
            (true, None, Some(object)) => {
                self.held = Some(world_from_hand.inverse() * object.isometry(BOX.rest_height_m()));
            }
            (true, Some(hand_from_object), _) => {
                let now = world_from_hand * hand_from_object;
                let (_, _, phi_rad) = now.rotation.euler_angles();
                self.object = Some(PlanarPose::new(now.translation.x, now.translation.y, phi_rad));
            }
            _ => self.held = None,
        }
        if self.held.is_none() {
            self.hand.step(commands, &world_from_hand, self.object.as_ref());
        }
    }

    /// Which hand links touch the object, bit i = link i.
    pub fn links(&self) -> u16 {
        let Some(object) = &self.object else { return 0 };
        let object_from_hand = object.isometry(BOX.rest_height_m()).inverse() * arm::hand_pose(&self.q_rad);
        let [f1, f2, f3, spread_rad] = self.hand.motor_q_rad;
        let poses = hand::link_poses(&object_from_hand, &HandAngles::engaged([f1, f2, f3], spread_rad));
        let mut links = 0;
        for (link, pose) in HandLink::ALL.iter().zip(poses) {
            let touches = BOX.separation_below(&pose, hand_prism(*link), TOUCH_M).is_some();
            links |= u16::from(touches) << link.index();
        }
        links
    }

    /// Takes the object away.
    pub fn remove_object(&mut self) {
        self.object = None;
        self.held = None;
    }

    /// Exact readings.
    pub fn readings(&self, tick: u32) -> JointReadings {
        let [f1, f2, f3, _] = self.hand.motor_q_rad;
        JointReadings {
            motor_q_rad: self.hand.motor_q_rad,
            inner_q_rad: [f1, f2, f3],
            tip_torque_nm: self.hand.felt.fingers.map(|felt| if felt { TOUCH_NM } else { 0.0 }),
            ..readings(tick, self.q_rad)
        }
    }
}

/// An image of F1's pad, pressed at one side (0) to the other (1).
pub fn pressed_across(at: f32) -> [Option<TactileImage>; PADS] {
    let mut pressure_n_cm2 = [0.0; PAD_CELLS];
    // The outer columns of the two rows with which a tip touches a face that it leans towards.
    for first in [12, 15] {
        (pressure_n_cm2[first], pressure_n_cm2[first + 2]) = (10.0 * (1.0 - at), 10.0 * at);
    }
    [Some(TactileImage { pad: 0, stamp: 0, pressure_n_cm2 }), None, None, None]
}

/// What a phase works with, owned, so that a test can step it by itself.
#[derive(Clone, Debug)]
pub struct Desk {
    /// Moves the arm; the readings follow it.
    pub executor: Executor,
    /// Contact detection.
    pub onset: Onset,
    /// Commands of the hand.
    pub hand: [HandCommand; HAND_MOTORS],
    /// Robot and object.
    pub bench: Bench,
    /// What is felt besides what the bench feels.
    pub felt: Felt,
    /// New images of the pads at the next tick.
    pub images: [Option<TactileImage>; PADS],
    /// The links of the hand tell what they touch.
    pub ideal_sensors: bool,
    /// What came out of the last step.
    pub out: Outputs,
    /// Ticks so far.
    pub tick: u32,
}

impl Default for Desk {
    fn default() -> Self {
        Self {
            executor: Executor::holding(home()),
            onset: Onset::default(),
            hand: [HandCommand::Idle; HAND_MOTORS],
            bench: Bench::default(),
            felt: Felt::default(),
            images: [None; PADS],
            ideal_sensors: false,
            out: Outputs::idle(0),
            tick: 0,
        }
    }
}

impl Desk {
    /// A desk with the hand far from any object.
    pub fn without_object() -> Self {
        let mut desk = Self::default();
        desk.bench.remove_object();
        desk
    }

    /// Loads a trajectory straight down by `descent_m` from above the place where the hand is to be.
    pub fn descend_to(&mut self, world_from_hand: &Isometry3<f32>) {
        let above = Translation3::new(0.0, 0.0, 0.1) * world_from_hand;
        let start = self.executor.reference().q_rad;
        let above = nearest_posture(&above, &start).expect("within reach");
        let below = nearest_posture(world_from_hand, &above).expect("within reach");
        self.executor.load(&through(1, &[start, above, below], 0.8)).expect("sound");
    }

    /// One tick: `step` gets its tools, then arm and hand move.
    pub fn tick<R>(&mut self, step: impl FnOnce(&mut Tools) -> R) -> R {
        self.answer(None, None, step)
    }

    /// One tick in which answers of the host have come.
    pub fn answer<R>(
        &mut self,
        plan: Option<&PlanAnswer>,
        rollout: Option<&RolloutResult>,
        step: impl FnOnce(&mut Tools) -> R,
    ) -> R {
        let readings = self.bench.readings(self.tick);
        let mut felt = self.bench.hand.felt;
        felt.palm |= self.felt.palm;
        for f in 0..FINGERS {
            felt.fingers[f] |= self.felt.fingers[f];
            felt.knocked[f] |= self.felt.knocked[f];
        }
        let images = core::mem::take(&mut self.images);
        let links = self.bench.links();
        self.out = Outputs::idle(self.tick);
        let mut tools = Tools {
            robot_base: MOUNT,
            readings: &readings,
            felt,
            images: &images,
            links: self.ideal_sensors.then_some(links),
            plan,
            rollout,
            executor: &mut self.executor,
            onset: &mut self.onset,
            hand: &mut self.hand,
            out: &mut self.out,
        };
        let result = step(&mut tools);
        self.executor.tick();
        self.bench.step(&self.executor.reference().q_rad, &self.hand);
        self.tick += 1;
        result
    }
}

/// An arm that moves as its torques demand: exact rigid-body dynamics, no friction, no flexible parts.
#[derive(Clone, Copy, Debug)]
pub struct ArmSim {
    /// Joint angles.
    pub q_rad: Joints,
    /// Joint velocities.
    pub qd_rad_s: Joints,
}

impl ArmSim {
    /// An arm at rest.
    pub fn at(q_rad: Joints) -> Self {
        Self { q_rad, qd_rad_s: [0.0; ARM_JOINTS] }
    }

    /// One tick under constant torques, in two steps of semi-implicit Euler.
    pub fn step(&mut self, tau_nm: &Joints, payload_kg: f32) {
        for _ in 0..2 {
            let bias_nm = dynamics::inverse_dynamics(&self.q_rad, &self.qd_rad_s, &[0.0; ARM_JOINTS], payload_kg);
            let weight_nm = dynamics::gravity(&self.q_rad, payload_kg);
            let mut mass = SMatrix::<f32, ARM_JOINTS, ARM_JOINTS>::zeros();
            for j in 0..ARM_JOINTS {
                let mut unit = [0.0; ARM_JOINTS];
                unit[j] = 1.0;
                let column = dynamics::inverse_dynamics(&self.q_rad, &[0.0; ARM_JOINTS], &unit, payload_kg);
                for i in 0..ARM_JOINTS {
                    mass[(i, j)] = column[i] - weight_nm[i];
                }
            }
            let force = SVector::<f32, ARM_JOINTS>::from_fn(|j, _| tau_nm[j] - bias_nm[j]);
            let qdd_rad_s2 = mass.lu().solve(&force).expect("a mass matrix is invertible");
            for j in 0..ARM_JOINTS {
                self.qd_rad_s[j] += qdd_rad_s2[j] * TICK_S / 2.0;
                self.q_rad[j] += self.qd_rad_s[j] * TICK_S / 2.0;
            }
        }
    }
}
