//! Barrett's puck protocol: what the motor controllers ("pucks") of the WAM and the BarrettHand say and obey on CAN.
//!
//! Classic CAN at 1 Mbit/s, 11-bit identifiers. The host sends [`Command`]s: GET or SET of a property, or four torques
//! packed in one frame, to one puck or to a group. Pucks answer a GET with one [`Report`] each and a SET with nothing.
//!
//! * [`address`]: who sends to whom: the identifier.
//! * [`property`]: what can be asked and set, by number.
//! * [`packed`]: 14-bit torques and 22-bit positions. [`tactile`]: the pads. [`force`]: the wrist's force sensor.
//! * [`state`]: what the numbers of STAT, MODE, ROLE, CMD and of the pendant mean.
//! * [`units`]: counts, torque units and the cables between motors and joints.
//!
//! Numbers and layouts as the public drivers of this hardware use them (libbarrett, OWD, pyHand, btclient) and as
//! Barrett's manuals give them; firmware from version 145 on ([`property::VERSION_MIN`]). A frame with any content
//! gives a message or an error, never a panic.

pub mod address;
pub mod force;
pub mod message;
pub mod packed;
pub mod property;
pub mod state;
pub mod tactile;
pub mod units;

pub use address::{Address, Destination, Group, Node};
pub use message::{Command, Feedback, Message, Order, ParseError, Report, Value};
pub use packed::{Counts, Position, Torques};
pub use property::Property;

#[cfg(test)]
mod tests;
