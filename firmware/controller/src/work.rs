//! How much long computations may do in one tick.

/// Work that is left in a tick, in separations of a link from the object: about 4,000 instructions each on a Cortex-M4F,
/// what lies between them included. Whoever computes stops at the first point where none is left, so a tick may take a
/// few more.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    left: u32,
}

impl Work {
    /// So many separations.
    pub const fn separations(count: u32) -> Self {
        Self { left: count }
    }

    /// As much as it takes: for callers that have no ticks.
    pub const fn unlimited() -> Self {
        Self::separations(u32::MAX)
    }

    /// Notes that this much was done.
    pub(crate) fn spend(&mut self, separations: u32) {
        self.left = self.left.saturating_sub(separations);
    }

    /// May more be done?
    pub fn is_left(&self) -> bool {
        self.left > 0
    }
}
