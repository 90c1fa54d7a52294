//! What the 29-bit identifier says: priority, subject, source.

use crate::can::{CanFrame, IdBits};

/// Priority of a transfer; the first wins the bus (specification, section 4.2.1.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Priority {
    /// Emergencies of the vehicle as a whole.
    Exceptional = 0,
    /// Must not wait.
    Immediate = 1,
    /// Fast control loops.
    Fast = 2,
    /// Above the ordinary.
    High = 3,
    /// The ordinary.
    Nominal = 4,
    /// May wait.
    Low = 5,
    /// May wait long.
    Slow = 6,
    /// Dispensable.
    Optional = 7,
}

impl Priority {
    /// All priorities, the most urgent first.
    pub const ALL: [Self; 8] = [
        Self::Exceptional,
        Self::Immediate,
        Self::Fast,
        Self::High,
        Self::Nominal,
        Self::Low,
        Self::Slow,
        Self::Optional,
    ];
}

/// Number of a node on the bus, 0..127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeId(u8);

impl NodeId {
    /// `None` above 127.
    pub const fn new(value: u8) -> Option<Self> {
        if value < 128 { Some(Self(value)) } else { None }
    }

    /// The number.
    pub const fn get(self) -> u8 {
        self.0
    }
}

/// Number of a subject (what a message is about), 0..8191.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SubjectId(u16);

impl SubjectId {
    /// `None` above 8191.
    pub const fn new(value: u16) -> Option<Self> {
        if value < 8192 { Some(Self(value)) } else { None }
    }

    /// The number.
    pub const fn get(self) -> u16 {
        self.0
    }
}

/// Error returned by [`Header::parse`]: the identifier is none of a message that we could want.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderError {
    /// A service call; our protocol has none.
    Service,
    /// A message from a node without a number; our protocol has none.
    Anonymous,
    /// Reserved bits 23 or 7 are set, or the value has more than 29 bits: to be discarded.
    Reserved,
    /// The frame has an 11-bit identifier: not Cyphal, somebody else's frame on the same wire.
    ShortId,
}

impl core::fmt::Display for HeaderError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Service => "a service transfer, not a message",
            Self::Anonymous => "a message from an anonymous node",
            Self::Reserved => "reserved identifier bits are set",
            Self::ShortId => "an 11-bit identifier",
        })
    }
}

impl core::error::Error for HeaderError {}

const SERVICE: u32 = 1 << 25;
const ANONYMOUS: u32 = 1 << 24;
/// Must be zero, or the frame is discarded.
const RESERVED_ZERO: u32 = (1 << 23) | (1 << 7);
/// Sent as ones, ignored when received.
const RESERVED_ONE: u32 = 0b11 << 21;

/// Priority, subject and source of a message, as its identifier carries them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// How urgent it is.
    pub priority: Priority,
    /// What it is about.
    pub subject: SubjectId,
    /// The node that sent it.
    pub source: NodeId,
}

impl Header {
    /// Reads the identifier of a frame.
    ///
    /// # Errors
    /// [`HeaderError`] if it is not that of a message with a source.
    pub const fn of(frame: &CanFrame) -> Result<Self, HeaderError> {
        match frame.id_bits() {
            IdBits::Base => Err(HeaderError::ShortId),
            IdBits::Extended => Self::parse(frame.id()),
        }
    }

    /// Reads a 29-bit identifier.
    ///
    /// # Errors
    /// [`HeaderError`] if it is not that of a message with a source.
    pub const fn parse(id: u32) -> Result<Self, HeaderError> {
        if id > crate::can::ID_MAX {
            return Err(HeaderError::Reserved);
        }
        if id & SERVICE != 0 {
            return Err(HeaderError::Service);
        }
        if id & RESERVED_ZERO != 0 {
            return Err(HeaderError::Reserved);
        }
        if id & ANONYMOUS != 0 {
            return Err(HeaderError::Anonymous);
        }
        Ok(Self {
            // In bounds: three bits, eight priorities.
            priority: Priority::ALL[((id >> 26) & 7) as usize],
            subject: SubjectId(((id >> 8) & 0x1fff) as u16),
            source: NodeId((id & 0x7f) as u8),
        })
    }

    /// The 29-bit identifier; [`Header::parse`] inverts it.
    pub const fn id(&self) -> u32 {
        ((self.priority as u32) << 26) | RESERVED_ONE | ((self.subject.0 as u32) << 8) | self.source.0 as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_priority_subject_and_source_survives_emit_and_parse() {
        for priority in Priority::ALL {
            for subject in (0..8192).map(|value| SubjectId::new(value).unwrap()) {
                let source = NodeId::new((subject.get() % 128) as u8).unwrap();
                let header = Header { priority, subject, source };
                assert_eq!(Header::parse(header.id()), Ok(header));
            }
        }
    }

    #[test]
    fn services_anonymous_nodes_and_reserved_bits_are_told_apart() {
        let id = 0x107d_552a; // Specification, section 4.2.3: heartbeat of node 42.
        assert_eq!(Header::parse(id).map(|header| header.subject.get()), Ok(7509));
        assert_eq!(Header::parse(0x136b_957b), Err(HeaderError::Service)); // same section, node info request
        assert_eq!(Header::parse(0x1113_3775), Err(HeaderError::Anonymous)); // same section, anonymous string
        assert_eq!(Header::parse(id | 1 << 23), Err(HeaderError::Reserved));
        assert_eq!(Header::parse(id | 1 << 7), Err(HeaderError::Reserved));
        assert_eq!(Header::parse(id | 1 << 29), Err(HeaderError::Reserved));
        // Bits 22 and 21 are not checked when receiving.
        assert_eq!(Header::parse(id & !(0b11 << 21)), Header::parse(id));
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        assert_eq!(NodeId::new(128), None);
        assert_eq!(SubjectId::new(8192), None);
    }

    #[test]
    fn a_short_identifier_is_never_read_as_one_of_ours() {
        // Taken for a long one, it would be a message of priority 0.
        let frame = |id| CanFrame::new_base(id, &[1], crate::can::Mtu::Classic).unwrap();
        for id in 0..=crate::can::BASE_ID_MAX {
            assert_eq!(Header::of(&frame(id)), Err(HeaderError::ShortId));
        }
        let long = CanFrame::new(0x10_0102, &[1], crate::can::Mtu::Classic).unwrap();
        assert_eq!(Header::of(&long), Header::parse(0x10_0102));
    }
}
