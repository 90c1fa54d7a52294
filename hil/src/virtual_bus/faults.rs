//! What may go wrong on the wire, by seed.

use rand_core::Rng;
use rand_pcg::Pcg32;

/// How often what goes wrong, in parts per million. The same seed gives the same faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Faults {
    /// A receiver misses a frame that the others get (its queue or its controller was not quick enough).
    pub loss_ppm: u32,
    /// A frame is seen as damaged by all and sent again: costs time, loses nothing.
    pub damage_ppm: u32,
    /// A frame is received, but its sender misses the acknowledgement and sends it again.
    pub double_ppm: u32,
    /// Seed of the draws.
    pub seed: u64,
}

impl Faults {
    /// Nothing goes wrong, and nothing is drawn.
    pub const NONE: Self = Self { loss_ppm: 0, damage_ppm: 0, double_ppm: 0, seed: 0 };
}

/// What becomes of a frame on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    Intact,
    Damaged,
    Doubled,
}

pub(super) struct FaultDice {
    faults: Faults,
    random: Pcg32,
}

impl FaultDice {
    pub(super) fn new(faults: Faults) -> Self {
        /// Any number will do; it sets these draws apart from others with the same seed.
        const STREAM: u64 = 0x00ca_4b05;
        Self { faults, random: Pcg32::new(faults.seed, STREAM) }
    }

    pub(super) fn fate(&mut self) -> Fate {
        if self.hits(self.faults.damage_ppm) {
            Fate::Damaged
        } else if self.hits(self.faults.double_ppm) {
            Fate::Doubled
        } else {
            Fate::Intact
        }
    }

    pub(super) fn loses(&mut self) -> bool {
        self.hits(self.faults.loss_ppm)
    }

    fn hits(&mut self, ppm: u32) -> bool {
        ppm > 0 && (u64::from(self.random.next_u32()) * 1_000_000) >> 32 < u64::from(ppm)
    }
}
