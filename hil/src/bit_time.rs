//! How many bits a frame takes on the wire, and how long they take.
//!
//! ISO 11898-1:2015. A node that has sent five equal bits inserts one of the other value, so the length depends on the
//! content. CAN 2.0 stuffs from start of frame to the end of the CRC; CAN FD stuffs that way up to the end of the data
//! and puts stuff bits at fixed places in the CRC field, so that its CRC has no influence on the length. Counted are
//! all bits up to and with the three bits of intermission, after which the wire is free.
//!
//! CAN FD changes to the data rate at the sample point of the BRS bit and back at that of the CRC delimiter. With both
//! sample points at the same fraction of a bit, that amounts to BRS at the nominal and the delimiter at the data rate,
//! as counted here. Left out: an acknowledgement that spills into a second bit on a long line.

pub use tactus_common::can::IdBits;
use tactus_common::can::{CanFrame, Mtu};

/// Length of a bit in the two phases of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRates {
    /// Arbitration phase, and all of a CAN 2.0 frame, nanoseconds a bit.
    pub nominal_bit_ns: u32,
    /// Data phase of CAN FD, nanoseconds a bit.
    pub data_bit_ns: u32,
}

impl BitRates {
    /// 1 Mbit/s, and 5 Mbit/s in the data phase: the project's bus.
    pub const M1_5: Self = Self { nominal_bit_ns: 1_000, data_bit_ns: 200 };
}

/// Bits of a frame by phase, with intermission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireBits {
    /// Bits at the nominal rate.
    pub nominal: u32,
    /// Bits at the data rate: 0 in CAN 2.0.
    pub data: u32,
}

impl WireBits {
    /// All bits.
    pub const fn total(self) -> u32 {
        self.nominal + self.data
    }

    /// How long they take, nanoseconds.
    pub const fn duration_ns(self, rates: BitRates) -> u64 {
        self.nominal as u64 * rates.nominal_bit_ns as u64 + self.data as u64 * rates.data_bit_ns as u64
    }
}

/// Bits between two frames.
pub const INTERMISSION_BITS: u32 = 3;
/// ACK slot, ACK delimiter, end of frame, intermission.
const TRAILER_BITS: u32 = 1 + 1 + 7 + INTERMISSION_BITS;
/// Start of frame, identifier 11, SRR, IDE, identifier 18, RTR, r1, r0, data length code 4. With a short identifier
/// 20 less: IDE follows RTR, and there are no SRR, no 18 further bits and no r1.
const CLASSIC_HEADER_BITS: u32 = 39;
const CLASSIC_BASE_HEADER_BITS: u32 = CLASSIC_HEADER_BITS - 20;
/// CRC of CAN 2.0, and its delimiter.
const CLASSIC_CRC_BITS: u32 = 15;
const CRC_DELIMITER_BITS: u32 = 1;
/// Start of frame, identifier 11, SRR, IDE, identifier 18, RRS, FDF, res, BRS. With a short identifier 19 less.
const FD_NOMINAL_BITS: u32 = 36;
const FD_BASE_NOMINAL_BITS: u32 = FD_NOMINAL_BITS - 19;
/// ESI, data length code 4.
const FD_CONTROL_BITS: u32 = 5;

/// Stuff count 4, CRC 17 (up to 16 data bytes) or 21, with a fixed stuff bit first and after each four bits of these.
const fn fd_crc_field_bits(data_bytes: usize) -> u32 {
    let content = 4 + if data_bytes <= 16 { 17 } else { 21 };
    content + 1 + content / 4
}

/// The exact length of a frame.
pub fn wire_bits(frame: &CanFrame) -> WireBits {
    match frame.mtu() {
        Mtu::Classic => classic_bits(frame),
        Mtu::Fd => fd_bits(frame),
    }
}

/// Bits up to the data length code (CAN 2.0) or the BRS bit (CAN FD).
const fn header_bits(mtu: Mtu, id: IdBits) -> u32 {
    match (mtu, id) {
        (Mtu::Classic, IdBits::Base) => CLASSIC_BASE_HEADER_BITS,
        (Mtu::Classic, IdBits::Extended) => CLASSIC_HEADER_BITS,
        (Mtu::Fd, IdBits::Base) => FD_BASE_NOMINAL_BITS,
        (Mtu::Fd, IdBits::Extended) => FD_NOMINAL_BITS,
    }
}

/// The identifier as sent, start of frame (0) first. 29 bits: 11 upper bits, SRR and IDE recessive (1), 18 lower bits,
/// RTR or RRS dominant (0). 11 bits: RTR or RRS, then IDE, both dominant.
fn arbitration_field(frame: &CanFrame) -> u64 {
    let id = u64::from(frame.id());
    match frame.id_bits() {
        IdBits::Base => id << 2,
        IdBits::Extended => (id >> 18 << 20 | 0b11 << 18 | id & 0x3_ffff) << 1,
    }
}

fn classic_bits(frame: &CanFrame) -> WireBits {
    // r1 (29 bits only) and r0 dominant (0), data length code.
    let reserved_bits = if frame.id_bits() == IdBits::Base { 1 } else { 2 };
    let header_bits = header_bits(Mtu::Classic, frame.id_bits());
    let header = arbitration_field(frame) << reserved_bits << 4 | u64::from(frame.dlc());
    // The CRC starts from zero, so leading zeros do not change it and make whole bytes.
    let mut digest = CRC_15.digest();
    digest.update(&header.to_be_bytes());
    digest.update(frame.data());
    let crc = u64::from(digest.finalize());

    let mut stuffing = Stuffing::after_start_of_frame();
    stuffing.bits(header, header_bits - 1);
    stuffing.bytes(frame.data());
    stuffing.bits(crc, CLASSIC_CRC_BITS);
    let stuff = stuffing.count + u32::from(stuffing.is_due());
    let content = header_bits + 8 * frame.data().len() as u32 + CLASSIC_CRC_BITS;
    WireBits { nominal: content + stuff + CRC_DELIMITER_BITS + TRAILER_BITS, data: 0 }
}

fn fd_bits(frame: &CanFrame) -> WireBits {
    let mut stuffing = Stuffing::after_start_of_frame();
    // FDF 1, res 0, BRS 1: after these no stuff bit is due, so each belongs wholly to one phase.
    let header_bits = header_bits(Mtu::Fd, frame.id_bits());
    stuffing.bits(arbitration_field(frame) << 3 | 0b101, header_bits - 1);
    let nominal_stuff = stuffing.count;
    stuffing.bits(u64::from(frame.dlc()), FD_CONTROL_BITS); // ESI 0: error active
    stuffing.bytes(frame.data());
    // A stuff bit due after the last data bit is not sent: the CRC field's first fixed one takes its place.
    let data_stuff = stuffing.count - nominal_stuff;
    let bytes = frame.data().len();
    WireBits {
        nominal: header_bits + nominal_stuff + TRAILER_BITS,
        data: FD_CONTROL_BITS + 8 * bytes as u32 + data_stuff + fd_crc_field_bits(bytes) + CRC_DELIMITER_BITS,
    }
}

/// A bound for the length of any frame with `data_bytes` data bytes: a stuff bit after the first five bits and after
/// each further four. CAN 2.0: `g + 8n + 13 + floor((g + 8n - 1) / 4)` with `g` = 34 or 54 (Davis et al., *Controller
/// Area Network schedulability analysis*, 2007). CAN FD likewise (Linux, `include/linux/can/length.h`).
pub const fn wire_bits_worst(data_bytes: usize, mtu: Mtu, id: IdBits) -> WireBits {
    let header = header_bits(mtu, id);
    let data_bits = 8 * data_bytes as u32;
    match mtu {
        Mtu::Classic => {
            let stuffed = header + data_bits + CLASSIC_CRC_BITS;
            WireBits { nominal: stuffed + (stuffed - 1) / 4 + CRC_DELIMITER_BITS + TRAILER_BITS, data: 0 }
        }
        Mtu::Fd => {
            let stuff = (header + FD_CONTROL_BITS + data_bits - 1) / 4;
            let nominal_stuff = (header - 1) / 4;
            WireBits {
                nominal: header + nominal_stuff + TRAILER_BITS,
                data: FD_CONTROL_BITS + data_bits + stuff - nominal_stuff
                    + fd_crc_field_bits(data_bytes)
                    + CRC_DELIMITER_BITS,
            }
        }
    }
}

static CRC_15: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_15_CAN);

/// Longest run of equal bits.
const RUN_MAX: u8 = 5;
/// Value of the last bit (0, 1) times its run length (1..5).
const STATES: usize = 2 * RUN_MAX as usize;

/// Counts stuff bits. The state is (last bit, length of its run); a stuff bit falls due when the run reaches five and is
/// counted when the next bit comes, so that the end of the stuffed part can decide about the last one.
struct Stuffing {
    state: u8,
    count: u32,
}

impl Stuffing {
    /// Start of frame is a 0.
    fn after_start_of_frame() -> Self {
        Self { state: state(0, 1), count: 0 }
    }

    /// The lowest `count` bits of `value`, the highest first.
    fn bits(&mut self, value: u64, count: u32) {
        let mut left = count;
        while left >= 8 {
            left -= 8;
            self.byte((value >> left) as u8);
        }
        while left > 0 {
            left -= 1;
            let (state, stuffed) = after_bit(self.state, (value >> left & 1) as u8);
            self.state = state;
            self.count += u32::from(stuffed);
        }
    }

    fn bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.byte(*byte));
    }

    fn byte(&mut self, byte: u8) {
        let step = AFTER_BYTE[usize::from(self.state)][usize::from(byte)];
        self.state = step & 0xf;
        self.count += u32::from(step >> 4);
    }

    /// Is a stuff bit due after the last bit?
    fn is_due(&self) -> bool {
        self.state % RUN_MAX == RUN_MAX - 1
    }
}

const fn state(bit: u8, run: u8) -> u8 {
    bit * RUN_MAX + run - 1
}

/// The state after one more bit, and how many stuff bits (0, 1) came before it.
const fn after_bit(from: u8, bit: u8) -> (u8, u8) {
    let (mut last, mut run, mut stuffed) = (from / RUN_MAX, from % RUN_MAX + 1, 0);
    if run == RUN_MAX {
        (last, run, stuffed) = (1 - last, 1, 1);
    }
    let run = if bit == last { run + 1 } else { 1 };
    (state(bit, run), stuffed)
}

/// For each state and byte: the state after it (low half), stuff bits on the way (high half).
static AFTER_BYTE: [[u8; 256]; STATES] = {
    let mut table = [[0; 256]; STATES];
    let mut from = 0;
    while from < STATES {
        let mut byte = 0;
        while byte < 256 {
            let (mut state, mut count, mut left) = (from as u8, 0, 8);
            while left > 0 {
                left -= 1;
                let (next, stuffed) = after_bit(state, (byte >> left & 1) as u8);
                state = next;
                count += stuffed;
            }
            table[from][byte] = count << 4 | state;
            byte += 1;
        }
        from += 1;
    }
    table
};

#[cfg(test)]
mod tests;
