//! What share of the wire a set of periodic messages takes at worst.

use crate::bit_time::{BitRates, IdBits, wire_bits_worst};
use tactus_common::can::Mtu;
use tactus_common::cyphal::frame_lengths;

/// A message that is sent again and again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// Name for tables.
    pub name: &'static str,
    /// Longest payload, bytes.
    pub payload_bytes: usize,
    /// Time from one to the next, microseconds. Several senders of one message are several entries, or a shorter period.
    pub period_us: u32,
}

/// What one transfer costs at worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransferCost {
    /// Frames.
    pub frames: u32,
    /// Time on the wire, nanoseconds, with worst bit stuffing and intermissions.
    pub worst_ns: u64,
}

/// The cost of a transfer with a payload of `payload_bytes`.
pub fn transfer_cost(payload_bytes: usize, mtu: Mtu, rates: BitRates) -> TransferCost {
    frame_lengths(payload_bytes, mtu).fold(TransferCost { frames: 0, worst_ns: 0 }, |cost, bytes| TransferCost {
        frames: cost.frames + 1,
        worst_ns: cost.worst_ns + wire_bits_worst(bytes, mtu, IdBits::Extended).duration_ns(rates),
    })
}

impl Periodic {
    /// Share of the wire at worst: 1 = all of it.
    pub fn worst_load(&self, mtu: Mtu, rates: BitRates) -> f64 {
        transfer_cost(self.payload_bytes, mtu, rates).worst_ns as f64 / (f64::from(self.period_us) * 1e3)
    }
}

/// Share of the wire that all messages together take at worst: 1 = all of it.
pub fn worst_load(messages: &[Periodic], mtu: Mtu, rates: BitRates) -> f64 {
    messages.iter().map(|message| message.worst_load(mtu, rates)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Placeholders of the size that the messages are expected to have; the real ones are checked beside the messages.
    fn messages(tick_us: u32) -> [Periodic; 5] {
        [
            Periodic { name: "SensorFrame", payload_bytes: 65, period_us: tick_us },
            Periodic { name: "Command", payload_bytes: 34, period_us: tick_us },
            Periodic { name: "TactileSlice", payload_bytes: 41, period_us: 25_000 / 4 },
            Periodic { name: "Status", payload_bytes: 80, period_us: 100_000 },
            Periodic { name: "Heartbeat", payload_bytes: 7, period_us: 1_000_000 },
        ]
    }

    #[test]
    fn costs_are_those_computed_by_hand() {
        // 65 + 2 bytes of CRC = 63 + 4: frames of 64 and 5 bytes.
        // 64: nominal 36 + 8 + 12, data 5 + 512 + 130 + 32 + 1. 5: nominal the same, data 5 + 40 + 12 + 27 + 1.
        let fd = transfer_cost(65, Mtu::Fd, BitRates::M1_5);
        assert_eq!(fd, TransferCost { frames: 2, worst_ns: (56_000 + 680 * 200) + (56_000 + 85 * 200) });
        // 67 = 9 x 7 + 4: nine frames of 160 bits, one with 5 data bytes: 80 + 50.
        let classic = transfer_cost(65, Mtu::Classic, BitRates::M1_5);
        assert_eq!(classic, TransferCost { frames: 10, worst_ns: 9 * 160_000 + 130_000 });
    }

    #[test]
    fn fd_carries_500_hz_with_at_most_80_percent_load() {
        let load = worst_load(&messages(2_000), Mtu::Fd, BitRates::M1_5);
        println!("CAN FD 1/5 Mbit/s at 500 Hz: {:.1} %", load * 100.0);
        assert!(load <= 0.80, "{load}");
    }

    #[test]
    fn classic_carries_250_hz_but_not_500_hz() {
        let load = worst_load(&messages(4_000), Mtu::Classic, BitRates::M1_5);
        println!("CAN 2.0 1 Mbit/s at 250 Hz: {:.1} %", load * 100.0);
        assert!(load <= 1.0, "{load}");
        assert!(worst_load(&messages(2_000), Mtu::Classic, BitRates::M1_5) > 1.0);
    }
}
