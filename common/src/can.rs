//! CAN and CAN FD data frames, as values: no heap, no driver.
//!
//! The shape follows `embedded_can::Frame` (identifier, data, length code), so that a driver needs a few lines to
//! convert. Our own protocol has 29-bit identifiers ([`crate::cyphal`]), Barrett's pucks have 11-bit ones
//! ([`crate::puck`]); both may share a wire. Remote frames occur in neither.

/// Most data bytes in one frame (CAN FD).
pub const DATA_BYTES_MAX: usize = 64;

/// Largest 29-bit identifier.
pub const ID_MAX: u32 = (1 << 29) - 1;

/// Largest 11-bit identifier.
pub const BASE_ID_MAX: u16 = (1 << 11) - 1;

/// Length of a frame's identifier. Frames of equal number and different length are different frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IdBits {
    /// 11 bits (Barrett's pucks).
    Base,
    /// 29 bits (Cyphal).
    Extended,
}

/// Which frames a transfer is cut into: the bus's frame format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mtu {
    /// CAN 2.0: up to 8 data bytes a frame.
    Classic,
    /// CAN FD: up to 64 data bytes a frame.
    Fd,
}

impl Mtu {
    /// Both formats.
    pub const ALL: [Self; 2] = [Self::Classic, Self::Fd];

    /// Most data bytes in one frame of this format.
    pub const fn bytes(self) -> usize {
        match self {
            Self::Classic => 8,
            Self::Fd => DATA_BYTES_MAX,
        }
    }

    /// Shortest frame of this format that holds `data_bytes` bytes: the data length that a length code can express.
    /// `None` if no frame is that long.
    pub const fn frame_bytes(self, data_bytes: usize) -> Option<usize> {
        match (self, data_bytes) {
            (_, 0..=8) => Some(data_bytes),
            (Self::Classic, _) => None,
            (Self::Fd, 9..=12) => Some(12),
            (Self::Fd, 13..=16) => Some(16),
            (Self::Fd, 17..=20) => Some(20),
            (Self::Fd, 21..=24) => Some(24),
            (Self::Fd, 25..=32) => Some(32),
            (Self::Fd, 33..=48) => Some(48),
            (Self::Fd, 49..=64) => Some(64),
            (Self::Fd, _) => None,
        }
    }
}

/// Error returned by [`CanFrame::new`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The identifier needs more bits than it may have.
    Id,
    /// No frame of this format has that many data bytes (CAN 2.0: 0-8; CAN FD: also 12, 16, 20, 24, 32, 48, 64).
    Length,
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Id => "CAN identifier has too many bits",
            Self::Length => "no CAN frame has this data length",
        })
    }
}

impl core::error::Error for FrameError {}

/// One data frame. A value of this type can be sent.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct CanFrame {
    id: u32,
    id_bits: IdBits,
    len: u8,
    mtu: Mtu,
    /// Bytes from `len` on are zero, so that equality of frames is equality of these fields.
    data: [u8; DATA_BYTES_MAX],
}

impl CanFrame {
    /// A frame of format `mtu` with identifier `id` (29 bits) and these data bytes.
    ///
    /// # Errors
    /// [`FrameError`] if the identifier or the data length does not exist in this format; nothing is padded here.
    pub fn new(id: u32, data: &[u8], mtu: Mtu) -> Result<Self, FrameError> {
        if id > ID_MAX {
            return Err(FrameError::Id);
        }
        Self::with_id(id, IdBits::Extended, data, mtu)
    }

    /// A frame of format `mtu` with the 11-bit identifier `id` and these data bytes.
    ///
    /// # Errors
    /// As [`CanFrame::new`].
    pub fn new_base(id: u16, data: &[u8], mtu: Mtu) -> Result<Self, FrameError> {
        if id > BASE_ID_MAX {
            return Err(FrameError::Id);
        }
        Self::with_id(u32::from(id), IdBits::Base, data, mtu)
    }

    /// A CAN 2.0 frame with the lowest eleven bits of `id` as identifier.
    pub fn classic_base<const N: usize>(id: u16, data: [u8; N]) -> Self {
        const { assert!(N <= Mtu::Classic.bytes(), "CAN 2.0 carries at most 8 data bytes") };
        let mut bytes = [0; DATA_BYTES_MAX];
        for (to, from) in bytes.iter_mut().zip(data) {
            *to = from;
        }
        Self { id: u32::from(id & BASE_ID_MAX), id_bits: IdBits::Base, len: N as u8, mtu: Mtu::Classic, data: bytes }
    }

    fn with_id(id: u32, id_bits: IdBits, data: &[u8], mtu: Mtu) -> Result<Self, FrameError> {
        if mtu.frame_bytes(data.len()) != Some(data.len()) {
            return Err(FrameError::Length);
        }
        let mut bytes = [0; DATA_BYTES_MAX];
        for (to, from) in bytes.iter_mut().zip(data) {
            *to = *from;
        }
        Ok(Self { id, id_bits, len: data.len() as u8, mtu, data: bytes })
    }

    /// The identifier; its length is [`CanFrame::id_bits`].
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// How long the identifier is.
    pub const fn id_bits(&self) -> IdBits {
        self.id_bits
    }

    /// Place in arbitration: of two frames the one with the lower number wins the bus. The eleven upper bits decide
    /// first; where these are equal the short identifier wins (ISO 11898-1: its next bit is dominant, SRR is not).
    pub const fn arbitration(&self) -> u32 {
        match self.id_bits {
            IdBits::Base => self.id << 19,
            IdBits::Extended => (self.id >> 18) << 19 | 1 << 18 | self.id & 0x3_ffff,
        }
    }

    /// The data bytes.
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// The frame's format.
    pub const fn mtu(&self) -> Mtu {
        self.mtu
    }

    /// Is this a CAN FD frame?
    pub const fn is_fd(&self) -> bool {
        matches!(self.mtu, Mtu::Fd)
    }

    /// Data length code, 0-15 (ISO 11898-1, table of data length codes).
    pub const fn dlc(&self) -> u8 {
        match self.len {
            12 => 9,
            16 => 10,
            20 => 11,
            24 => 12,
            32 => 13,
            48 => 14,
            64 => 15,
            short => short,
        }
    }
}

impl core::fmt::Debug for CanFrame {
    /// As candump writes frames: `107D552A#00000000000000E0`, three digits for 11-bit identifiers, `##` for CAN FD.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let digits = if self.id_bits == IdBits::Base { 3 } else { 8 };
        write!(f, "{:0digits$X}{}", self.id, if self.is_fd() { "##" } else { "#" })?;
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lengths_with_a_length_code_make_a_frame() {
        let bytes = [7; 80];
        let lengths = |mtu| (0..80).filter(|&n| CanFrame::new(1, &bytes[..n], mtu).is_ok()).count();
        assert_eq!(lengths(Mtu::Classic), 9);
        assert_eq!(lengths(Mtu::Fd), 16);
        assert_eq!(CanFrame::new(1, &bytes[..9], Mtu::Classic), Err(FrameError::Length));
        assert_eq!(CanFrame::new(1, &bytes[..9], Mtu::Fd), Err(FrameError::Length));
        assert_eq!(CanFrame::new(1, &bytes[..65], Mtu::Fd), Err(FrameError::Length));
    }

    #[test]
    fn length_codes_count_up_without_gap() {
        let bytes = [0; 64];
        let codes: heapless::Vec<u8, 16> =
            (0..=64).filter_map(|n| CanFrame::new(1, &bytes[..n], Mtu::Fd).ok()).map(|frame| frame.dlc()).collect();
        assert!(codes.iter().copied().eq(0..16), "{codes:?}");
    }

    #[test]
    fn an_identifier_of_thirty_bits_is_refused() {
        assert_eq!(CanFrame::new(ID_MAX + 1, &[], Mtu::Fd), Err(FrameError::Id));
        assert_eq!(CanFrame::new(ID_MAX, &[1, 2], Mtu::Classic).map(|frame| frame.id()), Ok(ID_MAX));
    }

    #[test]
    fn a_frame_gives_back_what_it_was_made_of() {
        let frame = CanFrame::new(0x123, &[9, 8, 7], Mtu::Classic).unwrap();
        assert_eq!((frame.id(), frame.data(), frame.mtu(), frame.dlc()), (0x123, &[9, 8, 7][..], Mtu::Classic, 3));
        assert_ne!(CanFrame::new(0x123, &[9, 8, 7, 0], Mtu::Classic), Ok(frame));
    }

    #[test]
    fn an_identifier_of_twelve_bits_is_no_short_one() {
        assert_eq!(CanFrame::new_base(BASE_ID_MAX + 1, &[], Mtu::Classic), Err(FrameError::Id));
        let frame = CanFrame::new_base(BASE_ID_MAX, &[1], Mtu::Classic).unwrap();
        assert_eq!((frame.id(), frame.id_bits()), (0x7ff, IdBits::Base));
        assert_eq!(CanFrame::classic_base(0x7ff, [1]), frame);
        assert_ne!(CanFrame::new(0x7ff, &[1], Mtu::Classic), Ok(frame), "the same number at another length");
    }

    #[test]
    fn arbitration_compares_the_upper_eleven_bits_and_then_prefers_the_short_identifier() {
        let base = |id| CanFrame::new_base(id, &[], Mtu::Classic).unwrap().arbitration();
        let extended = |id| CanFrame::new(id, &[], Mtu::Classic).unwrap().arbitration();
        assert!(base(0x404) < base(0x405));
        assert!(base(0x404) < extended(0x404 << 18), "equal upper bits");
        assert!(extended(0x404 << 18) < extended(0x404 << 18 | 1));
        assert!(extended(0x403 << 18 | 0x3_ffff) < base(0x404), "the lower upper bits win, however long");
        assert!(base(BASE_ID_MAX) < extended(ID_MAX));
    }

    #[test]
    fn frames_are_shown_as_candump_writes_them() {
        extern crate std;
        let show = |frame: Result<CanFrame, FrameError>| std::format!("{:?}", frame.unwrap());
        assert_eq!(show(CanFrame::new_base(0x00b, &[5], Mtu::Classic)), "00B#05");
        assert_eq!(show(CanFrame::new(0x107d_552a, &[0xe0], Mtu::Fd)), "107D552A##E0");
    }
}
