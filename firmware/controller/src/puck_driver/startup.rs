//! Before the first tick: who is there, is it what this driver is written for, what is its torque unit, may it move.
//!
//! One question at a time, first to the safety module, then to each motor's puck, then to the safety module again. A puck
//! in its boot loader is woken. The arm must have been zeroed and the hand initialised before (Barrett's own tools do
//! both); that the operator activates the robot is waited for.

use super::{Calibration, set_tactile};
use tactus_common::can::CanFrame;
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS};
use tactus_common::puck::property::{VERSION_MIN, motor, safety};
use tactus_common::puck::state::{Role, SafetyMode, Status};
use tactus_common::puck::tactile::Request;
use tactus_common::puck::{Command, Feedback, Message, Node, Property};
use tactus_common::robot::tables::{ARM_MOTOR_COUNTS, HAND_MOTOR_COUNTS};

/// Ticks to wait for an answer: 20 ms.
const ANSWER_TICKS: u16 = 10;
/// Times that a question is asked.
const TRIES: u8 = 3;
/// Ticks that a puck may take to leave its boot loader: 1.2 s.
const WAKE_TICKS: u16 = 600;
/// Ticks between two questions whether the operator has activated the robot: 0.1 s.
const OPERATOR_TICKS: u16 = 50;
/// Motor poles of M7 on a wrist; gimbals have 8 there.
const WRIST_POLES: i32 = 6;
/// Motors of arm and hand.
const MOTORS: usize = ARM_JOINTS + HAND_MOTORS;

/// Why the robot cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartError {
    /// A node does not answer.
    Silent(Node),
    /// A puck reports an error, or stays in its boot loader.
    NotReady(Node),
    /// Firmware for which the property numbers are not known to hold.
    Firmware(Node, i32),
    /// A puck of another kind than its number says, or a finger without strain gauge: the value of ROLE.
    Role(Node, i32),
    /// Another number of encoder counts per turn than in the robot's description.
    Counts(Node, i32),
    /// A torque unit that makes no sense.
    TorqueUnit(Node, i32),
    /// The arm ends in gimbals, not in a wrist: motor poles of M7.
    NoWrist(i32),
    /// The arm's position has not been set since power-up.
    NotZeroed,
}

/// How far the start-up is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartState {
    /// Asks.
    Asking,
    /// All is well; waits for the operator to activate the robot.
    AwaitsOperator,
    /// Ready; with this the driver can begin.
    Ready(Calibration),
    /// Ended.
    Failed(StartError),
}

/// Whom the questions go to: the safety module, the motors, the safety module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subject {
    Safety,
    Motor(usize),
    Release,
}

impl Subject {
    fn node(self) -> Node {
        match self {
            Self::Safety | Self::Release => Node::SAFETY,
            Self::Motor(m) => {
                Node::ARM.get(m).or(Node::HAND.get(m.wrapping_sub(ARM_JOINTS))).copied().unwrap_or(Node::SAFETY)
            }
        }
    }

    /// What it is asked, in turn.
    fn questions(self) -> &'static [Property] {
        const EACH: [Property; 5] = [motor::STAT, motor::VERS, motor::ROLE, motor::CTS, motor::IPNM];
        const LAST_OF_ARM: [Property; 6] =
            [motor::STAT, motor::VERS, motor::ROLE, motor::CTS, motor::IPNM, motor::POLES];
        match self {
            Self::Safety => &[motor::STAT],
            Self::Motor(m) if m + 1 == ARM_JOINTS => &LAST_OF_ARM,
            Self::Motor(_) => &EACH,
            Self::Release => &[safety::ZERO, motor::MODE],
        }
    }

    fn next(self) -> Option<Self> {
        match self {
            Self::Safety => Some(Self::Motor(0)),
            Self::Motor(m) if m + 1 < MOTORS => Some(Self::Motor(m + 1)),
            Self::Motor(_) => Some(Self::Release),
            Self::Release => None,
        }
    }
}

/// What an answer leads to.
enum Verdict {
    Good,
    /// Wake it and ask again.
    Asleep,
    /// Ask again later.
    Later,
    Bad(StartError),
}

/// The start-up; give it a tick each 2 ms and every frame that comes.
#[derive(Clone, Copy, Debug)]
pub struct Startup {
    state: StartState,
    subject: Subject,
    question: usize,
    wait: u16,
    tries: u8,
    woken: bool,
    found: Calibration,
}

impl Default for Startup {
    fn default() -> Self {
        Self {
            state: StartState::Asking,
            subject: Subject::Safety,
            question: 0,
            wait: 0,
            tries: 0,
            woken: false,
            found: Calibration::default(),
        }
    }
}

impl Startup {
    /// How far it is.
    pub fn state(&self) -> StartState {
        self.state
    }

    fn asked(&self) -> Option<Property> {
        self.subject.questions().get(self.question).copied()
    }

    /// One tick: asks, asks again, or gives up.
    pub fn tick(&mut self, send: &mut dyn FnMut(CanFrame)) {
        if matches!(self.state, StartState::Ready(_) | StartState::Failed(_)) {
            return;
        }
        if self.wait > 0 {
            self.wait -= 1;
            return;
        }
        if self.tries == TRIES {
            self.state = StartState::Failed(StartError::Silent(self.subject.node()));
            return;
        }
        if let Some(property) = self.asked() {
            self.tries += 1;
            self.wait = ANSWER_TICKS;
            send(Command::get(self.subject.node(), property).frame());
        }
    }

    /// Takes a frame from the bus; others than the answer to the present question are passed over.
    pub fn receive(&mut self, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) {
        if matches!(self.state, StartState::Ready(_) | StartState::Failed(_)) || self.tries == 0 {
            return;
        }
        let Ok(Message::Report(report)) = Message::parse(frame) else { return };
        let Feedback::Value(property, value) = report.feedback() else { return };
        if report.from() != self.subject.node() || Some(property) != self.asked() {
            return;
        }
        self.tries = 0;
        match self.judge(property, value.get()) {
            Verdict::Good => self.advance(send),
            Verdict::Asleep => {
                self.woken = true;
                self.wait = WAKE_TICKS;
                send(Command::set_long(report.from(), motor::STAT, Status::Ready.number().into()).frame());
            }
            Verdict::Later => {
                self.wait = OPERATOR_TICKS;
                self.state = StartState::AwaitsOperator;
            }
            Verdict::Bad(error) => self.state = StartState::Failed(error),
        }
    }

    /// The next question, the next node, or the end.
    fn advance(&mut self, send: &mut dyn FnMut(CanFrame)) {
        self.wait = 0;
        self.question += 1;
        if self.asked().is_some() {
            return;
        }
        (self.question, self.woken) = (0, false);
        match self.subject.next() {
            Some(subject) => self.subject = subject,
            None => {
                // Unloaded now: the pads' zero.
                Node::HAND.iter().for_each(|node| send(set_tactile(*node, Request::Tare)));
                self.state = StartState::Ready(self.found);
            }
        }
    }

    fn judge(&mut self, property: Property, value: i32) -> Verdict {
        let node = self.subject.node();
        let demand = |good: bool, error: StartError| if good { Verdict::Good } else { Verdict::Bad(error) };
        match (self.subject, property) {
            (_, motor::STAT) => match Status::from_number(value) {
                Some(Status::Ready) => Verdict::Good,
                Some(Status::Reset) if !self.woken => Verdict::Asleep,
                Some(Status::Reset | Status::Error) | None => Verdict::Bad(StartError::NotReady(node)),
            },
            (Subject::Motor(_), motor::VERS) => demand(value >= VERSION_MIN, StartError::Firmware(node, value)),
            (Subject::Motor(m), motor::ROLE) => demand(role_fits(m, Role(value as u16)), StartError::Role(node, value)),
            (Subject::Motor(m), motor::CTS) => {
                let expected = if m < ARM_JOINTS { ARM_MOTOR_COUNTS } else { HAND_MOTOR_COUNTS };
                demand(i64::from(value) == i64::from(expected), StartError::Counts(node, value))
            }
            (Subject::Motor(m), motor::IPNM) => {
                let mut units = self.found.arm_ipnm.iter_mut().chain(&mut self.found.hand_ipnm);
                if let Some(unit) = units.nth(m) {
                    *unit = value as f32;
                }
                demand(value > 0, StartError::TorqueUnit(node, value))
            }
            (Subject::Motor(_), motor::POLES) => demand(value == WRIST_POLES, StartError::NoWrist(value)),
            (Subject::Release, safety::ZERO) => demand(value == 1, StartError::NotZeroed),
            (Subject::Release, motor::MODE) => match SafetyMode::from_number(value) {
                Some(SafetyMode::Active) => Verdict::Good,
                Some(SafetyMode::Idle | SafetyMode::EmergencyStop) => Verdict::Later,
                None => Verdict::Bad(StartError::NotReady(node)),
            },
            // Not asked.
            _ => Verdict::Later,
        }
    }
}

/// Is it the kind of puck that motor `m` should have, with a strain gauge if it is a finger's?
fn role_fits(m: usize, role: Role) -> bool {
    if m < ARM_JOINTS {
        role.kind() == Role::ARM_MOTOR
    } else {
        role.kind() == Role::HAND_MOTOR && (m >= ARM_JOINTS + FINGERS || role.has(Role::STRAIN_GAUGE))
    }
}
