//! The other end of Barrett's puck protocol: a dozen pucks that answer questions and remember what they were told.
//!
//! As little as a driver needs to be tried out: positions, gauges and pads come from whoever plays the robot, and go out
//! when asked for; torques, modes and targets are kept and handed to him in SI units. Motors, safety module and groups
//! have the numbers of a WAM with wrist and of a BH8-282. Not here: trajectories, current loops, limits, the 1 s that a
//! puck takes to wake, the force sensor, EEPROM. Conversions are its own, in `f64`, so that it and a driver cannot share
//! a mistake.

use tactus_common::can::CanFrame;
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PAD_CELLS, PADS};
use tactus_common::puck::property::{motor, safety};
use tactus_common::puck::state::{Mode, SafetyMode, Status};
use tactus_common::puck::tactile::{FullFrame, Request};
use tactus_common::puck::{
    Command, Counts, Destination, Feedback, Group, Message, Node, Order, Position, Property, Report, Torques, Value,
};
use tactus_common::reading::HandCommand;

/// Encoder counts per motor turn, and per turn of a finger's second encoder.
const COUNTS: f64 = 4096.0;
const TAU: f64 = core::f64::consts::TAU;
/// Motor turns per joint turn: inner link three times, spread.
const HAND_GEARS: [f64; HAND_MOTORS] = [125.0, 125.0, 125.0, 17.5];
/// Turns of the second encoder per turn of the inner link.
const SECONDARY_GEAR: f64 = 50.0;

/// What the robot's sensors would show.
#[derive(Clone, Copy, Debug)]
pub struct RobotState {
    /// Arm joint angles, radians.
    pub arm_q_rad: [f64; ARM_JOINTS],
    /// Hand motors as joint angles, F1, F2, F3, spread, radians.
    pub motor_q_rad: [f64; HAND_MOTORS],
    /// Inner-link angles, radians.
    pub inner_q_rad: [f64; FINGERS],
    /// Fingertip torques, newton-metres, positive = pushed open.
    pub tip_torque_nm: [f64; FINGERS],
    /// Pressure of each cell of each pad, N/cm^2.
    pub pressure_n_cm2: [[f64; PAD_CELLS]; PADS],
}

impl Default for RobotState {
    fn default() -> Self {
        Self {
            arm_q_rad: [0.0; ARM_JOINTS],
            motor_q_rad: [0.0; HAND_MOTORS],
            inner_q_rad: [0.0; FINGERS],
            tip_torque_nm: [0.0; FINGERS],
            pressure_n_cm2: [[0.0; PAD_CELLS]; PADS],
        }
    }
}

/// One node: what it was told last, by property.
#[derive(Clone, Debug)]
struct Puck {
    node: Node,
    groups: [Group; 3],
    values: [i32; 128],
}

impl Puck {
    fn new(node: Node, groups: [Group; 3], values: &[(Property, i32)]) -> Self {
        let mut puck = Self { node, groups, values: [0; 128] };
        for (property, value) in [(motor::VERS, 200), (motor::STAT, Status::Ready.number().into())].iter().chain(values)
        {
            puck.set(*property, *value);
        }
        puck
    }

    fn get(&self, property: Property) -> i32 {
        self.values.get(usize::from(property.number())).copied().unwrap_or(0)
    }

    fn set(&mut self, property: Property, value: i32) {
        if let Some(place) = self.values.get_mut(usize::from(property.number())) {
            *place = value;
        }
    }

    fn hears(&self, to: Destination) -> bool {
        match to {
            Destination::Node(node) => node == self.node,
            Destination::Group(group) => self.groups.contains(&group),
        }
    }

    fn mode(&self) -> Option<Mode> {
        Mode::from_number(self.get(motor::MODE))
    }
}

/// The pucks; see the [module](self).
#[derive(Clone, Debug)]
pub struct PuckResponder {
    pucks: Vec<Puck>,
    state: RobotState,
    /// Raw value of the gauges without load.
    gauge_zero: f64,
    /// Raw values per newton-metre.
    gauge_per_nm: f64,
}

impl Default for PuckResponder {
    /// A robot that is zeroed, activated and at all angles 0.
    fn default() -> Self {
        let wam = [2700, 2562, 2562, 2700, 6500, 6500, 17474];
        let arm = Node::ARM.iter().zip(wam).enumerate().map(|(m, (node, ipnm))| {
            let torques = if m < 4 { Group::LOWER_ARM } else { Group::WRIST };
            let slot = if m < 4 { m + 1 } else { m - 3 } as i32;
            let values = [
                (motor::ROLE, 0x0100),
                (motor::CTS, 4096),
                (motor::IPNM, ipnm),
                (motor::PIDX, slot),
                (motor::POLES, if m == 6 { 6 } else { 12 }),
                // The safety module does this when it is activated.
                (motor::MODE, Mode::Torque.number().into()),
            ];
            Puck::new(*node, [Group::ALL_PUCKS, torques, Group::ARM], &values)
        });
        let hand = Node::HAND.iter().enumerate().map(|(m, node)| {
            let role = if m < FINGERS { 0x1805 } else { 0x1005 };
            let values = [(motor::ROLE, role), (motor::CTS, 4096), (motor::IPNM, 20_000), (motor::PIDX, m as i32 + 1)];
            Puck::new(*node, [Group::ALL_PUCKS, Group::SECONDARY, Group::HAND], &values)
        });
        let module = [(motor::ROLE, 2), (safety::ZERO, 1), (motor::MODE, SafetyMode::Active.number().into())];
        let safety = Puck::new(Node::SAFETY, [Group::LOWER_ARM, Group::WRIST, Group::POSITION], &module);
        Self {
            pucks: arm.chain(hand).chain([safety]).collect(),
            state: RobotState::default(),
            gauge_zero: 2000.0,
            gauge_per_nm: 1.0 / 0.000_816,
        }
    }
}

impl PuckResponder {
    /// What the sensors show from now on.
    pub fn set_state(&mut self, state: RobotState) {
        self.state = state;
    }

    /// Takes a frame; answers go to `send`. What is no command of the protocol is passed over.
    pub fn receive(&mut self, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) {
        let Ok(Message::Command(command)) = Message::parse(frame) else { return };
        let state = self.state;
        let (zero, per_nm) = (self.gauge_zero, self.gauge_per_nm);
        for puck in self.pucks.iter_mut().filter(|puck| puck.hears(command.address().to)) {
            obey(puck, &command, &state, zero, per_nm, send);
        }
    }

    fn puck(&self, node: Node) -> Option<&Puck> {
        self.pucks.iter().find(|puck| puck.node == node)
    }

    /// Value of a property of a node, as it was told last.
    pub fn value(&self, node: Node, property: Property) -> Option<i32> {
        self.puck(node).map(|puck| puck.get(property))
    }

    /// Joint torques that the arm's motors make now, newton-metres.
    pub fn arm_tau_nm(&self) -> [f64; ARM_JOINTS] {
        let [m1, m2, m3, m4, m5, m6, m7] = Node::ARM.map(|node| match self.puck(node) {
            Some(puck) if puck.mode() == Some(Mode::Torque) => {
                f64::from(puck.get(motor::T)) / f64::from(puck.get(motor::IPNM))
            }
            Some(_) | None => 0.0,
        });
        [-42.0 * m1, 28.25 * (m2 - m3), -16.8155 * (m2 + m3), -18.0 * m4, 9.7 * (m5 + m6), 9.7 * (m6 - m5), -14.93 * m7]
    }

    /// What the hand's motors do now, F1, F2, F3, spread, at the joint.
    pub fn hand(&self) -> [HandCommand; HAND_MOTORS] {
        core::array::from_fn(|m| {
            let Some(puck) = self.puck(Node::HAND[m]) else { return HandCommand::Idle };
            let count_rad = TAU / (COUNTS * HAND_GEARS[m]);
            match puck.mode() {
                Some(Mode::Trapezoidal) => HandCommand::Position((f64::from(puck.get(motor::E)) * count_rad) as f32),
                Some(Mode::Velocity) => HandCommand::Velocity((f64::from(puck.get(motor::V)) * 1e3 * count_rad) as f32),
                Some(Mode::Torque) => {
                    let motor_nm = f64::from(puck.get(motor::T)) / f64::from(puck.get(motor::IPNM));
                    HandCommand::Torque((motor_nm * HAND_GEARS[m]) as f32)
                }
                Some(Mode::Idle | Mode::Duty | Mode::Position) | None => HandCommand::Idle,
            }
        })
    }
}

/// Counts of an angle of what has `turns` encoder turns a turn, rounded down as an encoder does it.
fn counts(angle_rad: f64, turns: f64) -> Counts {
    Counts::saturated((angle_rad / TAU * COUNTS * turns).floor() as i32)
}

/// Motor of the arm as an angle, radians.
fn arm_motor_rad(m: usize, q: &[f64; ARM_JOINTS]) -> f64 {
    match m {
        0 => -42.0 * q[0],
        1 => 28.25 * q[1] - 16.8155 * q[2],
        2 => -28.25 * q[1] - 16.8155 * q[2],
        3 => -18.0 * q[3],
        4 => 9.7 * (q[4] - q[5]),
        5 => 9.7 * (q[4] + q[5]),
        _ => -14.93 * q[6],
    }
}

fn position(node: Node, state: &RobotState) -> Option<Position> {
    if let Some(m) = node.arm_motor() {
        return Some(Position { primary: counts(arm_motor_rad(m, &state.arm_q_rad), 1.0), secondary: None });
    }
    let m = node.hand_motor()?;
    let inner = state.inner_q_rad.get(m).copied().unwrap_or(0.0);
    Some(Position {
        primary: counts(state.motor_q_rad[m], HAND_GEARS[m]),
        secondary: Some(counts(inner, SECONDARY_GEAR)),
    })
}

fn obey(
    puck: &mut Puck,
    command: &Command,
    state: &RobotState,
    gauge_zero: f64,
    gauge_per_nm: f64,
    send: &mut dyn FnMut(CanFrame),
) {
    let node = puck.node;
    let mut tell = |feedback| {
        if let Some(report) = Report::new(node, feedback) {
            send(report.frame());
        }
    };
    match command.order() {
        Order::Get(motor::P) if position(node, state).is_some() => {
            if let Some(position) = position(node, state) {
                tell(Feedback::Position(position));
            }
        }
        Order::Get(motor::SG) if node.hand_motor().is_some() => {
            let tip_nm = node.hand_motor().and_then(|m| state.tip_torque_nm.get(m)).copied().unwrap_or(0.0);
            let raw = (gauge_zero + gauge_per_nm * tip_nm).round().clamp(0.0, 4095.0);
            tell(Feedback::Value(motor::SG, Value::Short(raw as i16)));
        }
        Order::Get(motor::TACT) => tell_pad(puck, state, send),
        Order::Get(property) => {
            let value = puck.get(property);
            let long = if node == Node::SAFETY { property == safety::PEN } else { property.is_long_on_motor() };
            let value = if long { Value::Long(value) } else { Value::Short(value as i16) };
            tell(Feedback::Value(property, value));
        }
        Order::Set(motor::TACT, value) => {
            // A tare leaves the format alone.
            if value.get() != i32::from(Request::Tare as i16) {
                puck.set(motor::TACT, value.get());
            }
            if value.get() == i32::from(Request::Full as i16) {
                tell_pad(puck, state, send);
            }
        }
        Order::Set(property, value) => puck.set(property, value.get()),
        Order::Torques(torques) => take_torque(puck, torques),
    }
}

fn take_torque(puck: &mut Puck, torques: Torques) {
    let slot = usize::try_from(puck.get(motor::PIDX) - 1).ok();
    if let Some(torque) = slot.and_then(|slot| torques.slots().get(slot).copied()) {
        puck.set(motor::T, torque.into());
    }
}

/// The pad of a hand puck, if whole images are selected.
fn tell_pad(puck: &Puck, state: &RobotState, send: &mut dyn FnMut(CanFrame)) {
    let Some(pressure_n_cm2) = puck.node.hand_motor().and_then(|pad| state.pressure_n_cm2.get(pad)) else { return };
    if puck.get(motor::TACT) != i32::from(Request::Full as i16) {
        return;
    }
    let image = pressure_n_cm2.map(|pressure| (pressure * 256.0).round().clamp(0.0, 4095.0) as u16);
    for frame in FullFrame::of_image(&image) {
        if let Some(report) = Report::new(puck.node, Feedback::TactileFull(frame)) {
            send(report.frame());
        }
    }
}
