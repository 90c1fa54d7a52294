//! Frames as values: what the host says and what pucks answer.

use super::address::{Address, Destination, Group, Node};
use super::force::Triple;
use super::packed::{Counts, Position, Torques};
use super::property::{self, Property};
use super::tactile::{FullFrame, Top10};
use crate::can::{CanFrame, IdBits, Mtu};

/// Marks a SET in the first byte.
const SET: u8 = 0x80;

/// Value of a property, as long as it was or will be sent. Either length is understood for any property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// 16 bits: a frame of 4 bytes.
    Short(i16),
    /// 32 bits: a frame of 6 bytes.
    Long(i32),
}

impl Value {
    /// The number.
    pub const fn get(self) -> i32 {
        match self {
            Self::Short(value) => value as i32,
            Self::Long(value) => value,
        }
    }
}

/// What the host wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Tell the value of a property.
    Get(Property),
    /// Set a property. Barrett's own library always sends the long form.
    Set(Property, Value),
    /// Set the torques of a group.
    Torques(Torques),
}

/// An order and whom it is for. The host sends them; the safety module sends some of its own to all pucks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    address: Address,
    order: Order,
}

impl Command {
    /// An order of the host's.
    pub fn new(to: impl Into<Destination>, order: Order) -> Self {
        Self { address: Address { from: Node::HOST, to: to.into() }, order }
    }

    /// GET of a property.
    pub fn get(to: impl Into<Destination>, property: Property) -> Self {
        Self::new(to, Order::Get(property))
    }

    /// SET of a property in the short form: 16 bits.
    pub fn set(to: impl Into<Destination>, property: Property, value: i16) -> Self {
        Self::new(to, Order::Set(property, Value::Short(value)))
    }

    /// SET of a property in the long form: 32 bits.
    pub fn set_long(to: impl Into<Destination>, property: Property, value: i32) -> Self {
        Self::new(to, Order::Set(property, Value::Long(value)))
    }

    /// SET of a group's torques.
    pub fn torques(to: Group, torques: Torques) -> Self {
        Self::new(to, Order::Torques(torques))
    }

    /// Sender and destination.
    pub const fn address(&self) -> Address {
        self.address
    }

    /// What is wanted.
    pub const fn order(&self) -> Order {
        self.order
    }

    /// The frame; [`Message::parse`] inverts it.
    pub fn frame(&self) -> CanFrame {
        let id = self.address.id();
        match self.order {
            Order::Get(property) => CanFrame::classic_base(id, [property.number()]),
            Order::Set(property, value) => value_frame(id, property, value),
            Order::Torques(torques) => {
                let [a, b, c, d, e, f, g] = torques.pack();
                CanFrame::classic_base(id, [SET | property::motor::T.number(), a, b, c, d, e, f, g])
            }
        }
    }
}

/// What a puck tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedback {
    /// Value of an ordinary property.
    Value(Property, Value),
    /// Position of the motor, and of the second encoder if there is one.
    Position(Position),
    /// Position of the second encoder alone (GET JP).
    Secondary(Counts),
    /// A fifth of a whole tactile image.
    TactileFull(FullFrame),
    /// The ten strongest cells of a pad.
    TactileTop(Top10),
    /// Force at the wrist.
    Force(Triple),
    /// Torque at the wrist.
    Torque(Triple),
    /// Acceleration at the wrist.
    Acceleration(Triple),
}

impl Feedback {
    const fn group(&self) -> Group {
        match self {
            Self::Value(..) => Group::VALUE,
            Self::Position(_) => Group::POSITION,
            Self::Secondary(_) => Group::SECONDARY,
            Self::TactileFull(_) => Group::TACTILE_FULL,
            Self::TactileTop(_) => Group::TACTILE_TOP,
            Self::Force(_) => Group::FORCE,
            Self::Torque(_) => Group::TORQUE,
            Self::Acceleration(_) => Group::ACCELERATION,
        }
    }
}

/// What a puck tells, and which one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    from: Node,
    feedback: Feedback,
}

impl Report {
    /// `None` from the host: it tells nothing.
    pub fn new(from: Node, feedback: Feedback) -> Option<Self> {
        (from != Node::HOST).then_some(Self { from, feedback })
    }

    /// The puck.
    pub const fn from(&self) -> Node {
        self.from
    }

    /// What it tells.
    pub const fn feedback(&self) -> Feedback {
        self.feedback
    }

    /// The frame; [`Message::parse`] inverts it.
    pub fn frame(&self) -> CanFrame {
        let id = Address { from: self.from, to: self.feedback.group().into() }.id();
        match self.feedback {
            Feedback::Value(property, value) => value_frame(id, property, value),
            Feedback::Position(Position { primary, secondary: None }) => CanFrame::classic_base(id, primary.pack()),
            Feedback::Position(Position { primary, secondary: Some(secondary) }) => {
                let ([a, b, c], [d, e, f]) = (primary.pack(), secondary.pack());
                CanFrame::classic_base(id, [a, b, c, d, e, f])
            }
            Feedback::Secondary(counts) => CanFrame::classic_base(id, counts.pack()),
            Feedback::TactileFull(frame) => CanFrame::classic_base(id, frame.pack()),
            Feedback::TactileTop(top) => CanFrame::classic_base(id, top.pack()),
            Feedback::Force(triple) | Feedback::Torque(triple) | Feedback::Acceleration(triple) => {
                let [a, b, c, d, e, f] = triple.pack();
                match triple.flags {
                    Some(flags) => CanFrame::classic_base(id, [a, b, c, d, e, f, flags]),
                    None => CanFrame::classic_base(id, [a, b, c, d, e, f]),
                }
            }
        }
    }
}

/// `0x80 | property`, 0, the value low byte first.
fn value_frame(id: u16, property: Property, value: Value) -> CanFrame {
    let first = SET | property.number();
    match value {
        Value::Short(value) => {
            let [a, b] = value.to_le_bytes();
            CanFrame::classic_base(id, [first, 0, a, b])
        }
        Value::Long(value) => {
            let [a, b, c, d] = value.to_le_bytes();
            CanFrame::classic_base(id, [first, 0, a, b, c, d])
        }
    }
}

/// Why a frame is no message of this protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParseError {
    /// Not a CAN 2.0 frame with an 11-bit identifier: somebody else's.
    Foreign,
    /// No message of this kind has that many data bytes.
    Length,
    /// A value without the mark in its first byte, or with a second byte that is not 0.
    Malformed,
    /// A tactile frame with an index above 4.
    FrameIndex(u8),
    /// A tactile map that does not name ten cells.
    Map(u32),
}

impl core::fmt::Display for ParseError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Foreign => f.write_str("not a CAN 2.0 frame with an 11-bit identifier"),
            Self::Length => f.write_str("no puck message of this kind has this length"),
            Self::Malformed => f.write_str("a value without mark or with a second byte that is not 0"),
            Self::FrameIndex(index) => write!(f, "tactile frame {index} of five"),
            Self::Map(map) => write!(f, "tactile map {map:06X} does not name ten cells"),
        }
    }
}

impl core::error::Error for ParseError {}

/// Any frame of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// To pucks.
    Command(Command),
    /// From a puck.
    Report(Report),
}

impl Message {
    /// Reads a frame.
    ///
    /// # Errors
    /// [`ParseError`] if it is not one of the protocol.
    pub fn parse(frame: &CanFrame) -> Result<Self, ParseError> {
        if frame.id_bits() != IdBits::Base || frame.mtu() != Mtu::Classic {
            return Err(ParseError::Foreign);
        }
        let address = Address::parse(frame.id()).ok_or(ParseError::Foreign)?;
        let data = frame.data();
        match address.to {
            Destination::Group(group) if address.from != Node::HOST => match parse_feedback(group, data)? {
                Some(feedback) => Ok(Self::Report(Report { from: address.from, feedback })),
                None => parse_order(data).map(|order| Self::Command(Command { address, order })),
            },
            Destination::Group(_) | Destination::Node(_) => {
                parse_order(data).map(|order| Self::Command(Command { address, order }))
            }
        }
    }
}

fn parse_order(data: &[u8]) -> Result<Order, ParseError> {
    match *data {
        [number] => Property::new(number).map(Order::Get).ok_or(ParseError::Malformed),
        [first, a, b, c, d, e, f, g] if first == SET | property::motor::T.number() => {
            Ok(Order::Torques(Torques::unpack([a, b, c, d, e, f, g])))
        }
        _ => parse_value(data).map(|(property, value)| Order::Set(property, value)),
    }
}

fn parse_value(data: &[u8]) -> Result<(Property, Value), ParseError> {
    let (first, second, value) = match *data {
        [first, second, a, b] => (first, second, Value::Short(i16::from_le_bytes([a, b]))),
        [first, second, a, b, c, d] => (first, second, Value::Long(i32::from_le_bytes([a, b, c, d]))),
        _ => return Err(ParseError::Length),
    };
    match Property::new(first & !SET) {
        Some(property) if first & SET != 0 && second == 0 => Ok((property, value)),
        _ => Err(ParseError::Malformed),
    }
}

/// What pucks send to a group of listeners; `None` if the group is not one of those.
fn parse_feedback(group: Group, data: &[u8]) -> Result<Option<Feedback>, ParseError> {
    let eight = || <[u8; 8]>::try_from(data).map_err(|_| ParseError::Length);
    let triple = || Triple::unpack(data).ok_or(ParseError::Length);
    Ok(Some(match group {
        Group::VALUE => {
            let (property, value) = parse_value(data)?;
            Feedback::Value(property, value)
        }
        Group::POSITION => match *data {
            [a, b, c] => Feedback::Position(Position { primary: Counts::unpack([a, b, c]), secondary: None }),
            [a, b, c, d, e, f] => Feedback::Position(Position {
                primary: Counts::unpack([a, b, c]),
                secondary: Some(Counts::unpack([d, e, f])),
            }),
            _ => return Err(ParseError::Length),
        },
        Group::SECONDARY => match *data {
            [a, b, c] => Feedback::Secondary(Counts::unpack([a, b, c])),
            _ => return Err(ParseError::Length),
        },
        Group::TACTILE_FULL => Feedback::TactileFull(FullFrame::unpack(eight()?).map_err(ParseError::FrameIndex)?),
        Group::TACTILE_TOP => Feedback::TactileTop(Top10::unpack(eight()?).map_err(ParseError::Map)?),
        Group::FORCE => Feedback::Force(triple()?),
        Group::TORQUE => Feedback::Torque(triple()?),
        Group::ACCELERATION => Feedback::Acceleration(triple()?),
        _ => return Ok(None),
    }))
}
