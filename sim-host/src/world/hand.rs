//! The hand's drives tied to the joints of the multibody: what moves the springs and reads them back.

use super::drive::{FingerDrive, FingerParams, JointState, Motor, MotorParams, Shaft};
use super::model::RobotModel;
use super::robot::Robot;
use rapier3d::prelude::PhysicsWorld;
use serde::{Deserialize, Serialize};
use tactus_common::reading::HandCommand;

/// What no source states, chosen as an engineer would: see each.
pub mod assumed {
    use super::Shaft;

    /// Worm to inner link. Steel gears and an aluminium link: 1 N m bends it by 5 mrad.
    pub const INNER: Shaft = Shaft { stiffness_nm_rad: 200.0, damping_nms_rad: 0.35 };
    /// Cable to the tip. Thin steel cable and the strain gauge's flexure: 1 N m over the gauge's range stretches it by 25 mrad.
    pub const TIP: Shaft = Shaft { stiffness_nm_rad: 40.0, damping_nms_rad: 0.04 };
    /// Spread gears to a knuckle.
    pub const SPREAD: Shaft = Shaft { stiffness_nm_rad: 150.0, damping_nms_rad: 0.5 };
    /// Speed at no load over the driver's default speed.
    pub const NO_LOAD_SPEED_RATIO: f32 = 1.3;
    /// Dry friction of a finger's motor and worms, N m at the inner joint (5 % of peak).
    pub const FINGER_FRICTION_NM: f32 = 0.23;
    /// Dry friction of the spread drive, N m.
    pub const SPREAD_FRICTION_NM: f32 = 0.1;
    /// Rotor of 10 g cm^2 through 125:1, times the worms' efficiency (their friction brakes the rotor's momentum too),
    /// kg m^2 at the inner joint. It decides how hard a fast finger presses when it stalls: about 25 N at full speed, the
    /// scale of the plot in MAN-H p.64 (facts 2.4).
    pub const FINGER_ROTOR_KGM2: f32 = 0.0156 * WORM_EFFICIENCY;
    /// The same rotor through 17.5:1, no worm.
    pub const SPREAD_ROTOR_KGM2: f32 = 3.1e-4;
    /// The finger's peak torque reaches the joint through two worm gears of about 40 %.
    pub const WORM_EFFICIENCY: f32 = 0.4;
    /// Spread acceleration, rad/s^2.
    pub const SPREAD_ACCELERATION_RAD_S2: f32 = 12.0;
}

/// Parameters of the hand's four drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandParams {
    /// F1, F2, F3.
    pub fingers: [FingerParams; 3],
    /// The spread's motor.
    pub spread: MotorParams,
    /// The gears from the spread's motor to each knuckle.
    pub spread_shaft: Shaft,
}

impl HandParams {
    /// The drives of a model, their clutches scaled by `breakaway`.
    pub fn new(model: &RobotModel, breakaway: &[f32; 3]) -> Self {
        let drive = &model.extra.hand.drive;
        let range_rad = model.joints.get(&model.extra.hand.inner_joints[0]).map_or([0.0, 2.44], |j| j.range_rad);
        let spread_range_rad =
            model.joints.get(&model.extra.hand.spread_joints[0]).map_or([0.0, core::f32::consts::PI], |j| j.range_rad);
        let motor = MotorParams {
            speed_max_rad_s: drive.finger_speed_rad_s,
            speed_no_load_rad_s: drive.finger_speed_rad_s * assumed::NO_LOAD_SPEED_RATIO,
            acceleration_rad_s2: drive.finger_acceleration_rad_s2,
            stall_nm: drive.motor_torque_peak_nm * drive.gear_inner * assumed::WORM_EFFICIENCY,
            friction_nm: assumed::FINGER_FRICTION_NM,
            rotor_inertia_kgm2: assumed::FINGER_ROTOR_KGM2,
            self_locking: true,
            range_rad,
        };
        let finger = |scale: f32| FingerParams {
            motor,
            inner: assumed::INNER,
            tip: assumed::TIP,
            breakaway_nm: drive.breakaway_torque_nm * scale,
        };
        Self {
            fingers: breakaway.map(finger),
            spread: MotorParams {
                speed_max_rad_s: drive.spread_speed_rad_s,
                speed_no_load_rad_s: drive.spread_speed_rad_s * assumed::NO_LOAD_SPEED_RATIO,
                acceleration_rad_s2: assumed::SPREAD_ACCELERATION_RAD_S2,
                stall_nm: drive.spread_torque_nm,
                friction_nm: assumed::SPREAD_FRICTION_NM,
                rotor_inertia_kgm2: assumed::SPREAD_ROTOR_KGM2,
                self_locking: false,
                range_rad: spread_range_rad,
            },
            spread_shaft: assumed::SPREAD,
        }
    }
}

/// Joint angles of a hand at rest with its clutches engaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandStart {
    /// Inner links F1, F2, F3, radians.
    pub inner_rad: [f32; 3],
    /// Spread, radians.
    pub spread_rad: f32,
}

/// State of the hand's drives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandDrives {
    /// F1, F2, F3.
    pub fingers: [FingerDrive; 3],
    /// The spread's motor.
    pub spread: Motor,
    /// Torque of the two knuckles on the spread's motor, N m, positive = they resist closing.
    pub spread_load_nm: f32,
    /// Inner joints after the last step.
    pub inner: [JointState; 3],
    /// Distal joints after the last step.
    pub distal: [JointState; 3],
}

impl HandDrives {
    /// A hand at rest; moves the joints of `robot` there too.
    pub fn start(
        physics: &mut PhysicsWorld,
        robot: &Robot,
        params: &HandParams,
        start: &HandStart,
        arm_q_rad: &[f32],
    ) -> Self {
        let mut angles: Vec<_> = robot.arm.iter().copied().zip(arm_q_rad.iter().copied()).collect();
        for f in 0..3 {
            angles.push((robot.inner[f], start.inner_rad[f]));
            angles.push((robot.tip[f], start.inner_rad[f] / 3.0));
        }
        angles.extend(robot.spread.iter().map(|j| (*j, start.spread_rad)));
        robot.set_angles(physics, &angles);
        let finger = &params.fingers[0];
        robot.add_hand_damping(
            physics,
            params.spread_shaft.damping_nms_rad,
            finger.inner.damping_nms_rad,
            finger.tip.damping_nms_rad,
        );
        let mut drives = Self {
            fingers: start.inner_rad.map(FingerDrive::at),
            spread: Motor::at(start.spread_rad),
            spread_load_nm: 0.0,
            inner: [JointState::default(); 3],
            distal: [JointState::default(); 3],
        };
        drives.feel(physics, robot, params);
        drives.set_springs(physics, robot, params, 1e-3);
        drives
    }

    /// Turns the motors by `dt_s` and moves the springs' rest angles along; call before the physics step.
    pub fn drive(
        &mut self,
        physics: &mut PhysicsWorld,
        robot: &Robot,
        params: &HandParams,
        commands: &[HandCommand; 4],
        dt_s: f32,
    ) {
        for (finger, (params, command)) in self.fingers.iter_mut().zip(params.fingers.iter().zip(commands)) {
            finger.step(params, *command, dt_s);
        }
        self.spread.step(&params.spread, commands[3], self.spread_load_nm, dt_s);
        self.set_springs(physics, robot, params, dt_s);
    }

    fn set_springs(&self, physics: &mut PhysicsWorld, robot: &Robot, params: &HandParams, dt_s: f32) {
        let shaft = &params.spread_shaft;
        let spread_rest = self.spread.q_rad + shaft.damping_nms_rad * self.spread.qd_rad_s / shaft.stiffness_nm_rad;
        let mut springs = [(robot.spread[0], shaft.stiffness_nm_rad, spread_rest); 8];
        springs[1].0 = robot.spread[1];
        for f in 0..3 {
            let finger = &params.fingers[f];
            let rests = self.fingers[f].rests(finger, self.inner[f], dt_s);
            springs[2 + 2 * f] = (robot.inner[f], finger.inner.stiffness_nm_rad, rests.inner_rad);
            springs[3 + 2 * f] = (robot.tip[f], finger.tip.stiffness_nm_rad, rests.distal_rad);
        }
        robot.set_springs(physics, &springs);
    }

    /// Reads joints and shaft torques; call after the physics step.
    pub fn feel(&mut self, physics: &PhysicsWorld, robot: &Robot, params: &HandParams) {
        let joints = [
            robot.spread[0],
            robot.spread[1],
            robot.inner[0],
            robot.tip[0],
            robot.inner[1],
            robot.tip[1],
            robot.inner[2],
            robot.tip[2],
        ];
        let states: [JointState; 8] = robot.states(physics, &joints);
        self.spread_load_nm = 0.0;
        for knuckle in &states[..2] {
            self.spread_load_nm += params
                .spread_shaft
                .torque_nm(self.spread.q_rad - knuckle.q_rad, self.spread.qd_rad_s - knuckle.qd_rad_s);
        }
        for f in 0..3 {
            self.inner[f] = states[2 + 2 * f];
            self.distal[f] = states[3 + 2 * f];
            self.fingers[f].feel(&params.fingers[f], self.inner[f], self.distal[f]);
        }
    }
}
