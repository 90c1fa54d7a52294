//! What crosses the wire: one struct per message, its subject and priority, and the schema version.
//!
//! `docs/protocol.md` says who sends which, when, and what its loss means. Values that travel every tick are
//! packed in fixed-width integers, so that a message's length never depends on its data.

mod from_controller;
mod from_world;
mod in_place;
mod packed;

pub use from_controller::*;
pub use from_world::*;

use postcard_schema::schema::NamedType;
use postcard_schema::{Schema, key::Key};
use serde::Serialize;

/// A message: where it travels.
pub trait Message: Serialize + Schema {
    /// Cyphal subject (13 bits).
    const SUBJECT: u16;
    /// Cyphal priority, 0 = exceptional .. 7 = optional.
    const PRIORITY: u8;
}

/// What a sniffer or a page of documentation needs to know of a message.
#[derive(Clone, Copy, Debug)]
pub struct Described {
    /// Its type's name.
    pub name: &'static str,
    /// [`Message::SUBJECT`].
    pub subject: u16,
    /// [`Message::PRIORITY`].
    pub priority: u8,
    /// Its layout.
    pub schema: &'static NamedType,
}

macro_rules! messages {
    ($($(#[$doc:meta])* $type:ty => $subject:literal, $priority:literal;)*) => {
        $($(#[$doc])* impl Message for $type {
            const SUBJECT: u16 = $subject;
            const PRIORITY: u8 = $priority;
        })*
        /// Every message, world's first.
        pub const MESSAGES: &[Described] = &[$(Described {
            name: stringify!($type),
            subject: <$type as Message>::SUBJECT,
            priority: <$type as Message>::PRIORITY,
            schema: <$type as Schema>::SCHEMA,
        }),*];
        /// Version of everything on the wire: a hash over the schema of every message. Two programs whose
        /// versions differ must not talk; [`Setup`] carries it.
        pub const SCHEMA_VERSION: u64 = {
            let mut hash = FNV_OFFSET;
            $( hash = fold(hash, Key::for_path::<$type>(stringify!($type)).to_bytes()); )*
            hash
        };
    };
}

messages! {
    Setup => 1100, 3;
    SensorFrame => 1101, 1;
    TactileSlice => 1102, 3;
    LinkContact => 1103, 2;
    PlanAnswer => 1104, 4;
    RolloutResult => 1105, 4;
    Command => 1200, 1;
    PlanRequest => 1201, 4;
    RolloutRequest => 1202, 4;
    Status => 1203, 5;
    Event => 1204, 3;
    DigestReport => 1205, 5;
    Hello => 1206, 5;
    Heartbeat => 7509, 4;
}

const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

const fn fold(mut hash: u64, bytes: [u8; 8]) -> u64 {
    let mut i = 0;
    while i < 8 {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(FNV_PRIME);
        i += 1;
    }
    hash
}

/// FNV-1a-64 over the bytes of messages: the digest of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Self(FNV_OFFSET)
    }
}

impl Digest {
    /// Adds bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.add(b);
        }
    }

    /// Adds one byte.
    pub fn add(&mut self, byte: u8) {
        self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(FNV_PRIME);
    }
}

/// The wire's node ids (Cyphal, 7 bits).
pub mod node {
    /// The world or the robot's gateway.
    pub const WORLD: u8 = 10;
    /// The controller.
    pub const CONTROLLER: u8 = 20;
}

#[cfg(test)]
mod tests;
