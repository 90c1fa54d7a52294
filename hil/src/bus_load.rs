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
    use tactus_common::limits::{PAD_PERIOD_TICKS, PADS, TICK_US};

    const PAGE: &str = include_str!("../../docs/protocol.md");

    /// Longest payload of a message, bytes: the last number of its row on the page, which a test of `common` holds
    /// against the messages themselves.
    fn payload_bytes(name: &str) -> usize {
        let row = PAGE.lines().find(|l| l.starts_with(&format!("| `{name}` |"))).expect("one row per message");
        let bytes = row.split('|').nth(4).expect("the fourth column");
        bytes.trim().rsplit('-').next().and_then(|most| most.parse().ok()).expect("a number of bytes")
    }

    /// All that is sent periodically while sensor messages come every `tick_us`.
    fn messages(tick_us: u32) -> [Periodic; 5] {
        let every = |name: &'static str, ticks: u32| Periodic {
            name,
            payload_bytes: payload_bytes(name),
            period_us: ticks * tick_us,
        };
        [
            every("SensorFrame", 1),
            every("Command", 1),
            // Four pads, each once in its period.
            Periodic { period_us: PAD_PERIOD_TICKS * TICK_US / PADS as u32, ..every("TactileSlice", 1) },
            Periodic { period_us: 100_000, ..every("Status", 1) },
            Periodic { period_us: 1_000_000, ..every("Heartbeat", 1) },
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
        let load = worst_load(&messages(TICK_US), Mtu::Fd, BitRates::M1_5);
        assert!(load <= 0.80, "{load}");
    }

    #[test]
    fn classic_carries_250_hz_but_not_500_hz() {
        let load = worst_load(&messages(2 * TICK_US), Mtu::Classic, BitRates::M1_5);
        assert!(load <= 1.0, "{load}");
        assert!(worst_load(&messages(TICK_US), Mtu::Classic, BitRates::M1_5) > 1.0);
    }

    #[test]
    fn the_page_gives_the_loads_that_are_computed() {
        let buses =
            [("CAN FD 1/5 Mbit/s, 500 Hz", Mtu::Fd, TICK_US), ("CAN 2.0 1 Mbit/s, 250 Hz", Mtu::Classic, 2 * TICK_US)];
        for (bus, mtu, tick_us) in buses {
            let messages = messages(tick_us);
            let mut row = format!("| {bus} |");
            for message in &messages {
                row += &format!(" {:.2} % |", 100.0 * message.worst_load(mtu, BitRates::M1_5));
            }
            row += &format!(" **{:.1} %** |", 100.0 * worst_load(&messages, mtu, BitRates::M1_5));
            assert!(PAGE.lines().any(|line| line == row), "docs/protocol.md lacks\n{row}");
        }
    }

    #[test]
    fn the_page_gives_the_time_that_answers_take_on_an_idle_wire() {
        for name in ["Setup", "PlanRequest", "PlanAnswer", "RolloutResult"] {
            let bytes = payload_bytes(name);
            let mut row = format!("| `{name}`, {bytes} bytes |");
            for mtu in [Mtu::Fd, Mtu::Classic] {
                let cost = transfer_cost(bytes, mtu, BitRates::M1_5);
                let plural = if cost.frames == 1 { "" } else { "s" };
                row += &format!(" {} frame{plural}, {:.1} ms |", cost.frames, cost.worst_ns as f64 * 1e-6);
            }
            assert!(PAGE.lines().any(|line| line == row), "docs/protocol.md lacks\n{row}");
        }
    }
}
