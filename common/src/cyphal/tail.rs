//! The last byte of every frame: where in its transfer the frame stands.

/// Transfer-IDs count 0..31 and start over.
pub const TRANSFER_ID_MODULO: u8 = 32;

const START: u8 = 1 << 7;
const END: u8 = 1 << 6;
const TOGGLE: u8 = 1 << 5;

/// The tail byte (specification, section 4.2.2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TailByte {
    /// First frame of its transfer?
    pub start: bool,
    /// Last frame of its transfer?
    pub end: bool,
    /// Set in the first frame, then alternates: tells a repeated frame from the next one.
    pub toggle: bool,
    /// Counts the transfers of a subject, 0..31.
    pub transfer_id: u8,
}

impl TailByte {
    /// Reads a tail byte; every value of a byte is one.
    pub const fn parse(byte: u8) -> Self {
        Self {
            start: byte & START != 0,
            end: byte & END != 0,
            toggle: byte & TOGGLE != 0,
            transfer_id: byte & (TRANSFER_ID_MODULO - 1),
        }
    }

    /// The byte; inverse of [`TailByte::parse`]. A transfer-ID beyond 31 wraps.
    pub const fn emit(self) -> u8 {
        (self.start as u8 * START)
            | (self.end as u8 * END)
            | (self.toggle as u8 * TOGGLE)
            | (self.transfer_id % TRANSFER_ID_MODULO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_parse_and_emit() {
        assert!((0..=u8::MAX).all(|byte| TailByte::parse(byte).emit() == byte));
    }
}
