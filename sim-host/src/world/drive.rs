//! The drives of the hand: motors, worm gears and the TorqueSwitch, all in joint units.
//!
//! A finger has one motor and two worm gears: one turns the inner link (125:1), the other pulls the cable that
//! sets the fingertip's angle *against the palm* (93.75:1), so `q_inner + q_distal = 4/3 motor` at all times.
//! The clutch between motor and inner worm lets go when the inner link resists with more than the breakaway
//! torque: the inner link then stays where its worm holds it and the tip goes on alone, four times as fast.
//! Numbers: the model's TOML. The shafts are stiff springs, so what they carry can be read off their bend.

use serde::{Deserialize, Serialize};
use tactus_common::reading::HandCommand;

/// Motor-to-absolute-tip gear relative to motor-to-inner: 125 / 93.75.
pub const TIP_PER_MOTOR: f32 = 4.0 / 3.0;

/// What one motor can do; torques, speeds and inertia at the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorParams {
    /// Fastest joint speed that the driver commands, rad/s.
    pub speed_max_rad_s: f32,
    /// Speed at no load and full voltage, rad/s; the speed that the load leaves falls linearly from here to 0 at stall.
    pub speed_no_load_rad_s: f32,
    /// Largest acceleration that the driver commands, rad/s^2.
    pub acceleration_rad_s2: f32,
    /// Torque at which the motor stalls, N m.
    pub stall_nm: f32,
    /// Dry friction of motor and gears, N m.
    pub friction_nm: f32,
    /// Rotor inertia seen at the joint, kg m^2.
    pub rotor_inertia_kgm2: f32,
    /// `true` for the worm gears of the fingers: a load cannot turn the motor.
    pub self_locking: bool,
    /// Range of the joint, radians.
    pub range_rad: [f32; 2],
}

/// State of one motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// Position as a joint angle, radians.
    pub q_rad: f32,
    /// Speed, rad/s.
    pub qd_rad_s: f32,
    /// Torque that the motor makes, as its current tells, N m; positive = closing.
    pub effort_nm: f32,
}

impl Motor {
    /// A motor at rest at `q_rad`.
    pub fn at(q_rad: f32) -> Self {
        Self { q_rad, qd_rad_s: 0.0, effort_nm: 0.0 }
    }

    /// Advances by `dt_s` under `command`, while the mechanism resists closing with `load_nm` (negative: it pulls).
    pub fn step(&mut self, params: &MotorParams, command: HandCommand, load_nm: f32, dt_s: f32) {
        match command {
            HandCommand::Idle => self.push(params, 0.0, load_nm, dt_s),
            HandCommand::Torque(tau_nm) => {
                self.push(params, tau_nm.clamp(-params.stall_nm, params.stall_nm), load_nm, dt_s);
            }
            HandCommand::Velocity(v_rad_s) => self.servo(params, v_rad_s, load_nm, dt_s),
            HandCommand::Position(target_rad) => {
                let target_rad = target_rad.clamp(params.range_rad[0], params.range_rad[1]);
                let error_rad = target_rad - self.q_rad;
                // The speed from which the motor can still stop at the target, and never more than arrives this step.
                let brake_rad_s = libm::sqrtf(2.0 * 0.9 * params.acceleration_rad_s2 * error_rad.abs());
                let v_rad_s = brake_rad_s.min(error_rad.abs() / dt_s);
                self.servo(params, v_rad_s.copysign(error_rad), load_nm, dt_s);
            }
        }
        if !self.q_rad.is_finite() || !self.qd_rad_s.is_finite() {
            return; // the world reports it
        }
        let bounded_rad = self.q_rad.clamp(params.range_rad[0], params.range_rad[1]);
        if bounded_rad != self.q_rad {
            self.q_rad = bounded_rad;
            self.qd_rad_s = 0.0;
        }
    }

    /// Resistance met when turning in `direction` (+-1), N m, friction included.
    fn resistance(params: &MotorParams, direction: f32, load_nm: f32) -> f32 {
        let load_nm = load_nm * direction;
        let load_nm = if params.self_locking { load_nm.max(0.0) } else { load_nm };
        load_nm + params.friction_nm
    }

    /// The driver's speed loop: follows `v_rad_s` as far as acceleration, supply and load allow.
    fn servo(&mut self, params: &MotorParams, v_rad_s: f32, load_nm: f32, dt_s: f32) {
        let direction = if v_rad_s != 0.0 { 1.0_f32.copysign(v_rad_s) } else { 1.0_f32.copysign(self.qd_rad_s) };
        let resistance_nm = Self::resistance(params, direction, load_nm);
        let spare = ((params.stall_nm - resistance_nm) / params.stall_nm).clamp(0.0, 1.0);
        let speed_rad_s = v_rad_s.abs().min(params.speed_max_rad_s).min(params.speed_no_load_rad_s * spare);
        let wanted_rad_s = speed_rad_s.copysign(v_rad_s);
        let change_max = params.acceleration_rad_s2 * dt_s;
        let before_rad_s = self.qd_rad_s;
        self.qd_rad_s += (wanted_rad_s - before_rad_s).clamp(-change_max, change_max);
        self.q_rad += self.qd_rad_s * dt_s;
        let inertia_nm = params.rotor_inertia_kgm2 * (self.qd_rad_s - before_rad_s) / dt_s;
        self.effort_nm = if self.qd_rad_s != 0.0 {
            direction * resistance_nm + inertia_nm
        } else if v_rad_s != 0.0 {
            params.stall_nm.copysign(v_rad_s) // stalled: the loop gives all it has
        } else if params.self_locking {
            0.0
        } else {
            load_nm
        };
        self.effort_nm = self.effort_nm.clamp(-params.stall_nm, params.stall_nm);
    }

    /// A constant torque: the motor moves where it overcomes load and friction, and sticks elsewhere.
    fn push(&mut self, params: &MotorParams, tau_nm: f32, load_nm: f32, dt_s: f32) {
        self.effort_nm = tau_nm;
        let closing_nm = tau_nm - Self::resistance(params, 1.0, load_nm);
        let opening_nm = -tau_nm - Self::resistance(params, -1.0, load_nm);
        let net_nm = if self.qd_rad_s > 0.0 {
            closing_nm
        } else if self.qd_rad_s < 0.0 {
            -opening_nm
        } else if closing_nm > 0.0 {
            closing_nm
        } else if opening_nm > 0.0 {
            -opening_nm
        } else {
            return;
        };
        let before_rad_s = self.qd_rad_s;
        let speed_max = params.speed_max_rad_s;
        // Back-EMF: the supply's torque falls off with speed.
        let net_nm = net_nm - before_rad_s * params.stall_nm / params.speed_no_load_rad_s;
        self.qd_rad_s = (before_rad_s + net_nm / params.rotor_inertia_kgm2 * dt_s).clamp(-speed_max, speed_max);
        if before_rad_s * self.qd_rad_s < 0.0 {
            self.qd_rad_s = 0.0; // passing through rest: friction decides anew
        }
        self.q_rad += self.qd_rad_s * dt_s;
    }
}

/// Stiffness and damping of one shaft or cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// N m/rad.
    pub stiffness_nm_rad: f32,
    /// N m s/rad, against the turning of its driving end.
    pub damping_nms_rad: f32,
}

impl Shaft {
    /// Torque that drives the far end, when it lags by `lag_rad` and `lag_rad_s`.
    pub fn torque_nm(&self, lag_rad: f32, lag_rad_s: f32) -> f32 {
        self.stiffness_nm_rad * lag_rad + self.damping_nms_rad * lag_rad_s
    }
}

/// Angle and speed of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Radians.
    pub q_rad: f32,
    /// rad/s.
    pub qd_rad_s: f32,
}

/// The parameters of a finger's drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerParams {
    /// The motor, in units of the inner joint.
    pub motor: MotorParams,
    /// From the inner worm to the inner link.
    pub inner: Shaft,
    /// The cable to the fingertip.
    pub tip: Shaft,
    /// Torque of the inner link at which the clutch lets go, N m.
    pub breakaway_nm: f32,
}

/// Rest angles of the two joint springs that stand for the shafts (see [`FingerDrive::rests`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rests {
    /// Inner joint, radians.
    pub inner_rad: f32,
    /// Distal joint, radians.
    pub distal_rad: f32,
}

/// One finger's motor, clutch and shafts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FingerDrive {
    /// The motor.
    pub motor: Motor,
    /// Motor position at which the clutch let go, if it has.
    pub broken_at_rad: Option<f32>,
    /// Torque from the worm into the inner link, N m, positive = closing.
    pub clutch_nm: f32,
    /// Torque of the cable about the distal joint, N m, positive = it closes the tip, the world opens it.
    pub cable_nm: f32,
}

impl FingerDrive {
    /// A finger at rest and engaged, its inner link at `q_rad`.
    pub fn at(q_rad: f32) -> Self {
        Self { motor: Motor::at(q_rad), broken_at_rad: None, clutch_nm: 0.0, cable_nm: 0.0 }
    }

    /// Angle and speed of the inner link's worm.
    fn worm(&self) -> JointState {
        match self.broken_at_rad {
            Some(q_rad) => JointState { q_rad, qd_rad_s: 0.0 },
            None => JointState { q_rad: self.motor.q_rad, qd_rad_s: self.motor.qd_rad_s },
        }
    }

    /// Load on the motor: what both worms ask for (virtual work), N m.
    pub fn load_nm(&self) -> f32 {
        let inner_nm = if self.broken_at_rad.is_some() { 0.0 } else { self.clutch_nm };
        inner_nm + TIP_PER_MOTOR * self.cable_nm
    }

    /// Turns the motor by one step, and opens or closes the clutch.
    pub fn step(&mut self, params: &FingerParams, command: HandCommand, dt_s: f32) {
        self.motor.step(&params.motor, command, self.load_nm(), dt_s);
        match self.broken_at_rad {
            None if self.motor.qd_rad_s > 0.0 && self.clutch_nm > params.breakaway_nm => {
                self.broken_at_rad = Some(self.motor.q_rad);
            }
            Some(at_rad) if self.motor.q_rad <= at_rad => self.broken_at_rad = None,
            _ => {}
        }
    }

    /// Where the springs on the two joints must rest, so that backward Euler over `dt_s` gives the shafts' torques.
    ///
    /// The cable's angle is measured against the palm: its pull acts on the inner joint too, and its stretch
    /// depends on the inner link. Both cross terms are taken from the last step; the springs' own terms are implicit.
    pub fn rests(&self, params: &FingerParams, inner: JointState, dt_s: f32) -> Rests {
        let worm = self.worm();
        let (ki, di) = (params.inner.stiffness_nm_rad, params.inner.damping_nms_rad);
        let (kt, dt) = (params.tip.stiffness_nm_rad, params.tip.damping_nms_rad);
        let tip_rad = TIP_PER_MOTOR * self.motor.q_rad - (inner.q_rad + inner.qd_rad_s * dt_s);
        let tip_rad_s = TIP_PER_MOTOR * self.motor.qd_rad_s - inner.qd_rad_s;
        Rests {
            inner_rad: worm.q_rad + (di * worm.qd_rad_s + self.cable_nm) / ki,
            distal_rad: tip_rad + dt * tip_rad_s / kt,
        }
    }

    /// Reads the shafts' torques off the joints after a step.
    pub fn feel(&mut self, params: &FingerParams, inner: JointState, distal: JointState) {
        let worm = self.worm();
        self.clutch_nm = params.inner.torque_nm(worm.q_rad - inner.q_rad, worm.qd_rad_s - inner.qd_rad_s);
        self.cable_nm = params.tip.torque_nm(
            TIP_PER_MOTOR * self.motor.q_rad - inner.q_rad - distal.q_rad,
            TIP_PER_MOTOR * self.motor.qd_rad_s - inner.qd_rad_s - distal.qd_rad_s,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params() -> FingerParams {
        FingerParams {
            motor: MotorParams {
                speed_max_rad_s: 2.5,
                speed_no_load_rad_s: 3.0,
                acceleration_rad_s2: 30.0,
                stall_nm: 4.6,
                friction_nm: 0.2,
                rotor_inertia_kgm2: 0.03,
                self_locking: true,
                range_rad: [0.0, 2.4435],
            },
            inner: Shaft { stiffness_nm_rad: 200.0, damping_nms_rad: 0.4 },
            tip: Shaft { stiffness_nm_rad: 40.0, damping_nms_rad: 0.04 },
            breakaway_nm: 1.0,
        }
    }

    #[test]
    fn a_position_command_arrives_without_overshoot_and_within_the_speed_limit() {
        let p = params().motor;
        let mut m = Motor::at(0.2);
        let mut fastest = 0.0_f32;
        for _ in 0..3000 {
            m.step(&p, HandCommand::Position(1.2), 0.0, 5e-4);
            fastest = fastest.max(m.qd_rad_s);
            assert!(m.q_rad <= 1.2 + 1e-4, "overshoot to {}", m.q_rad);
        }
        assert!((m.q_rad - 1.2).abs() < 1e-4, "{}", m.q_rad);
        assert!(fastest <= 2.5 + 1e-6 && fastest > 2.0, "{fastest}");
    }

    #[test]
    fn a_worm_holds_any_load_and_a_spread_motor_does_not() {
        for load_nm in [-20.0, 20.0] {
            let mut worm = Motor::at(1.0);
            let mut free = Motor::at(1.0);
            let backdrivable = MotorParams { self_locking: false, ..params().motor };
            for _ in 0..100 {
                worm.step(&params().motor, HandCommand::Idle, load_nm, 5e-4);
                free.step(&backdrivable, HandCommand::Idle, load_nm, 5e-4);
            }
            assert_eq!(worm.q_rad, 1.0);
            assert!((free.q_rad - 1.0) * load_nm < 0.0, "a load that resists closing opens the joint");
        }
    }

    #[test]
    fn a_torque_command_stalls_between_balance_and_what_its_momentum_adds() {
        let p = params().motor;
        let mut m = Motor::at(1.0);
        for _ in 0..20_000 {
            let load_nm = 50.0 * (m.q_rad - 1.0).max(0.0);
            m.step(&p, HandCommand::Torque(1.2), load_nm, 5e-4);
        }
        let load_nm = 50.0 * (m.q_rad - 1.0);
        assert!((0.97..1.5).contains(&load_nm), "stalled at {load_nm}, balance at 1.0");
        assert_eq!(m.qd_rad_s, 0.0);
    }

    #[test]
    fn past_breakaway_the_tip_goes_on_alone_and_the_clutch_takes_again_on_opening() {
        let p = params();
        let mut d = FingerDrive::at(0.8);
        // An inner link that cannot move, a tip that is free.
        let inner = JointState { q_rad: 0.8, qd_rad_s: 0.0 };
        let follow = |d: &FingerDrive| JointState { q_rad: TIP_PER_MOTOR * d.motor.q_rad - 0.8, qd_rad_s: 0.0 };
        for _ in 0..1000 {
            d.step(&p, HandCommand::Velocity(0.5), 5e-4);
            let tip = follow(&d);
            d.feel(&p, inner, tip);
        }
        let at_rad = d.broken_at_rad.expect("1 N m is exceeded after 5 mrad");
        assert!(at_rad < 0.82, "{at_rad}");
        let rests = d.rests(&p, inner, 5e-4);
        assert!(
            (rests.inner_rad + rests.distal_rad - TIP_PER_MOTOR * d.motor.q_rad).abs() < 0.02,
            "the cable law holds"
        );
        assert!(d.motor.q_rad > at_rad + 0.1);
        for _ in 0..2000 {
            d.step(&p, HandCommand::Velocity(-0.5), 5e-4);
            let tip = follow(&d);
            d.feel(&p, inner, tip);
        }
        assert_eq!(d.broken_at_rad, None);
    }
}
