//! A robot as simple as can be: rigid-body dynamics with damping for the arm, fingers that stop at the box.

use nalgebra::Isometry3;
use tactus_common::limits::{FINGERS, HAND_MOTORS, TICK_S};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::HandCommand;
use tactus_common::robot::arm;
use tactus_common::robot::hand::HandAngles;
use tactus_common::robot::tables::{ARM_DAMPING_NMS_RAD, FINGER_LIMIT, SPREAD_LIMIT};
use tactus_controller::onset::Felt;
use tactus_controller::testing::{ArmSim, BOX, TRUTH, cuts, home, setup};
use tactus_hil::puck_responder::RobotState;

/// Speed of a finger that moves to a position or pushes, rad/s.
const DRIVE_RAD_S: f32 = 2.0;
/// The object is felt this much before a link would cut into it, radians of the inner link.
const PROBE_RAD: f32 = 1e-3;
/// Torque of a fingertip that touches, newton-metres.
const TOUCH_NM: f32 = 0.2;
/// A motor goes on by this much when its inner link has stopped, radians.
const BEND_RAD: f32 = 2e-3;

/// By what this robot feels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feels {
    /// The fingertips' strain gauges; its links do not bend.
    Gauges,
    /// The bend between motor and inner link; its gauges are dead.
    Bend,
}

/// Arm, hand and box.
pub struct Robot {
    feels: Feels,
    arm: ArmSim,
    motor_q_rad: [f32; HAND_MOTORS],
    /// Inner-link angles, radians.
    pub inner_q_rad: [f32; FINGERS],
    /// What touches.
    pub felt: Felt,
    /// Where the box is.
    pub object: Option<PlanarPose>,
    /// The box in the hand's frame while it is held.
    held: Option<Isometry3<f32>>,
}

impl Robot {
    /// An arm at rest with its hand open, high above the box.
    pub fn new(feels: Feels) -> Self {
        Self {
            feels,
            arm: ArmSim::at(home()),
            motor_q_rad: [0.0; HAND_MOTORS],
            inner_q_rad: [0.0; FINGERS],
            felt: Felt::default(),
            object: Some(TRUTH),
            held: None,
        }
    }

    fn cuts(&self, inner_rad: [f32; FINGERS]) -> Felt {
        let angles = HandAngles::engaged(inner_rad, self.motor_q_rad[3]);
        self.object.map_or(Felt::default(), |o| cuts(&arm::hand_pose(&self.arm.q_rad), &angles, &o, &BOX))
    }

    /// One tick under these torques and hand commands.
    pub fn step(&mut self, tau_nm: &[f64; 7], commands: &[HandCommand; HAND_MOTORS]) {
        let mut tau = tau_nm.map(|t| t as f32);
        for (j, tau) in tau.iter_mut().enumerate() {
            *tau -= ARM_DAMPING_NMS_RAD[j] * self.arm.qd_rad_s[j];
        }
        self.arm.step(&tau, if self.held.is_some() { setup().mass_kg } else { 0.0 });
        self.carry(commands);
        if self.held.is_none() {
            (0..HAND_MOTORS).for_each(|m| self.drive(m, commands[m]));
            self.felt = self.cuts(self.inner_q_rad.map(|q| q + PROBE_RAD));
        }
    }

    fn drive(&mut self, m: usize, command: HandCommand) {
        let step = DRIVE_RAD_S * TICK_S;
        let change = match command {
            HandCommand::Idle => 0.0,
            HandCommand::Position(target) => (target - self.motor_q_rad[m]).clamp(-step, step),
            HandCommand::Velocity(speed) => speed * TICK_S,
            HandCommand::Torque(torque) => step.copysign(torque),
        };
        let limit = if m < FINGERS { FINGER_LIMIT } else { SPREAD_LIMIT };
        let motor = (self.motor_q_rad[m] + change).clamp(limit.lower_rad, limit.upper_rad);
        if m >= FINGERS {
            self.motor_q_rad[m] = motor;
            return;
        }
        // A link that bent follows its motor's way back only once that is straight again.
        let mut inner = self.inner_q_rad;
        inner[m] = if change < 0.0 { motor.min(inner[m]) } else { motor.max(inner[m]) };
        let stopped = change > 0.0 && self.cuts(inner).fingers[m];
        if !stopped {
            self.inner_q_rad[m] = inner[m];
            self.motor_q_rad[m] = motor;
        } else if self.feels == Feels::Bend {
            self.motor_q_rad[m] = motor.min(self.inner_q_rad[m] + BEND_RAD);
        }
    }

    /// Fingers on both sides that push hold the box.
    fn carry(&mut self, commands: &[HandCommand; HAND_MOTORS]) {
        let world_from_hand = arm::hand_pose(&self.arm.q_rad);
        let pushes = |f: usize| matches!(commands[f], HandCommand::Torque(t) if t > 0.0) && self.felt.fingers[f];
        match (pushes(2) && (pushes(0) || pushes(1)), self.held, self.object) {
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
    }

    /// What the sensors show.
    pub fn state(&self) -> RobotState {
        let tip = |felt| if felt && self.feels == Feels::Gauges { f64::from(TOUCH_NM) } else { 0.0 };
        RobotState {
            arm_q_rad: self.arm.q_rad.map(f64::from),
            motor_q_rad: self.motor_q_rad.map(f64::from),
            inner_q_rad: self.inner_q_rad.map(f64::from),
            tip_torque_nm: self.felt.fingers.map(tip),
            ..RobotState::default()
        }
    }
}
