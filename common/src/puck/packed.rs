//! Numbers that do not come in whole bytes: torques of 14 bits, positions of 22 bits, both in two's complement with
//! the high bits first.

/// Position in encoder counts, 22 bits: -2 097 152..=2 097 151.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Counts(i32);

impl Counts {
    /// Smallest position.
    pub const MIN: Self = Self(-(1 << 21));
    /// Largest position.
    pub const MAX: Self = Self((1 << 21) - 1);

    /// `None` outside 22 bits.
    pub const fn new(counts: i32) -> Option<Self> {
        if counts >= Self::MIN.0 && counts <= Self::MAX.0 { Some(Self(counts)) } else { None }
    }

    /// The nearest position of 22 bits.
    pub fn saturated(counts: i32) -> Self {
        Self(counts.clamp(Self::MIN.0, Self::MAX.0))
    }

    /// The counts.
    pub const fn get(self) -> i32 {
        self.0
    }

    /// Three bytes with bit 7 of the first set, as the pucks of the public drivers send it.
    pub const fn pack(self) -> [u8; 3] {
        let bits = self.0 as u32;
        [0x80 | (bits >> 16 & 0x3f) as u8, (bits >> 8) as u8, bits as u8]
    }

    /// Reads three bytes. The two upper bits of the first carry nothing: sources disagree on them.
    pub const fn unpack(raw: [u8; 3]) -> Self {
        let bits = (raw[0] as u32 & 0x3f) << 16 | (raw[1] as u32) << 8 | raw[2] as u32;
        // The sign bit of 22 moved up to that of 32 and back.
        Self((bits << 10) as i32 >> 10)
    }
}

/// Answer to GET P: 3 bytes, or 6 from a puck with a second encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Encoder of the motor.
    pub primary: Counts,
    /// Second encoder (worm of a finger, joint of an arm), if the puck has one.
    pub secondary: Option<Counts>,
}

/// Largest torque that is sent, puck units; the one smaller 14-bit number is not used.
pub const TORQUE_MAX: i16 = 8191;

/// Torques of a group of pucks: SET T with 8 bytes. A puck takes the slot that its property PIDX names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Torques([i16; 4]);

impl Torques {
    /// Torques in puck units, each cut to +-[`TORQUE_MAX`]. Slots that nobody reads are 0.
    pub fn clamped(slots: [i32; 4]) -> Self {
        let max = i32::from(TORQUE_MAX);
        Self(slots.map(|torque| torque.clamp(-max, max) as i16))
    }

    /// The slots, puck units, -8192..=8191.
    pub const fn slots(self) -> [i16; 4] {
        self.0
    }

    /// The seven bytes behind the property: 56 bits, the first slot highest.
    pub fn pack(self) -> [u8; 7] {
        let bits = self.0.iter().fold(0_u64, |bits, slot| bits << 14 | u64::from(*slot as u16 & 0x3fff));
        let [_, bytes @ ..] = bits.to_be_bytes();
        bytes
    }

    /// Reads the seven bytes behind the property.
    pub fn unpack(raw: [u8; 7]) -> Self {
        let bits = raw.iter().fold(0_u64, |bits, byte| bits << 8 | u64::from(*byte));
        // Each slot's sign bit of 14 moved up to that of 16 and back.
        Self([42, 28, 14, 0].map(|shift| ((bits >> shift << 2) as u16 as i16) >> 2))
    }
}
