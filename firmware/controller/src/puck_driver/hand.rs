//! What the hand's motors are to do, as modes and targets of their pucks.

use tactus_common::can::CanFrame;
use tactus_common::limits::HAND_MOTORS;
use tactus_common::puck::property::motor;
use tactus_common::puck::state::Mode;
use tactus_common::puck::units::{self, HAND_GEARS};
use tactus_common::puck::{Command, Counts, Node};
use tactus_common::reading::HandCommand;

/// Motors that are told something new in one tick at most: four frames, which the bus always has room for.
const MOTORS_PER_TICK: usize = 2;

/// A hand command in the units of a puck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Setting {
    /// No current.
    Idle,
    /// To this position, with the drive's own speed and acceleration.
    Move(Counts),
    /// At this velocity, counts per millisecond; 0 holds.
    Velocity(i16),
    /// With this torque, puck units.
    Torque(i16),
}

impl Setting {
    /// A value that is not a number makes idle, as on our own wire.
    fn of(command: HandCommand, gear: f32, ipnm: f32) -> Self {
        let short = |value: i32| value.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        match command {
            HandCommand::Position(q_rad) if q_rad.is_finite() => {
                Self::Move(Counts::saturated(units::hand_counts(q_rad, gear)))
            }
            HandCommand::Velocity(qd_rad_s) if qd_rad_s.is_finite() => {
                Self::Velocity(short(units::hand_counts_per_ms(qd_rad_s, gear)))
            }
            HandCommand::Torque(tau_nm) if tau_nm.is_finite() => {
                Self::Torque(short(units::torque_units(tau_nm / gear, ipnm)))
            }
            HandCommand::Idle | HandCommand::Position(_) | HandCommand::Velocity(_) | HandCommand::Torque(_) => {
                Self::Idle
            }
        }
    }

    /// Does it make the motor stand?
    fn stops(self) -> bool {
        matches!(self, Self::Idle | Self::Velocity(0))
    }

    /// Target, then mode, as Barrett's library sends them; a torque is passed over until the mode is there, so it comes
    /// after it. The mode is sent every time: a puck that ran against a stop has left it.
    fn send(self, node: Node, send: &mut dyn FnMut(CanFrame)) {
        let mode = |mode: Mode| Command::set(node, motor::MODE, mode.number()).frame();
        match self {
            Self::Idle => send(mode(Mode::Idle)),
            Self::Move(counts) => {
                send(Command::set_long(node, motor::E, counts.get()).frame());
                send(mode(Mode::Trapezoidal));
            }
            Self::Velocity(velocity) => {
                send(Command::set(node, motor::V, velocity).frame());
                send(mode(Mode::Velocity));
            }
            Self::Torque(torque) => {
                send(mode(Mode::Torque));
                send(Command::set(node, motor::T, torque).frame());
            }
        }
    }
}

/// What each motor was told last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HandOrders {
    told: [Option<Setting>; HAND_MOTORS],
}

impl HandOrders {
    /// Tells those motors for which something has changed, the ones that are to stand first, as many as a tick has room
    /// for; the others' turn comes at the next tick. How many were told.
    pub(super) fn update(
        &mut self,
        commands: &[HandCommand; HAND_MOTORS],
        ipnm: &[f32; HAND_MOTORS],
        send: &mut dyn FnMut(CanFrame),
    ) -> usize {
        let mut left = MOTORS_PER_TICK;
        for stopping in [true, false] {
            for (m, told) in self.told.iter_mut().enumerate() {
                let wanted = Setting::of(commands[m], HAND_GEARS[m], ipnm[m]);
                if left > 0 && wanted.stops() == stopping && *told != Some(wanted) {
                    wanted.send(Node::HAND[m], send);
                    *told = Some(wanted);
                    left -= 1;
                }
            }
        }
        MOTORS_PER_TICK - left
    }
}
