//! How much long computations may do in one tick.

/// Separation of a link from the object, in units of [`Work`].
pub(crate) const SEPARATION: u32 = 50;
/// Poses of a finger's links at new angles.
pub(crate) const POSES: u32 = 30;
/// A link's bounding sphere against the object.
pub(crate) const SPHERE: u32 = 2;
/// A few 3 x 3 matrices: one step of a search, the worth of one sample.
pub(crate) const MATRICES: u32 = 40;
/// Sorting and merging the ends of an update, or the covariances of its modes.
pub(crate) const GATHERING: u32 = 200;

/// Work that is left in a tick, in units of about a hundred instructions of a Cortex-M4F. Whoever computes stops at the
/// first point where none is left, so that a tick may take one indivisible piece more.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    left: u32,
}

impl Work {
    /// What a tick has to spare besides control and messages: two thirds of its budget of 168,000 instructions.
    pub const PER_TICK: Self = Self::units(750);

    /// So many units.
    pub const fn units(count: u32) -> Self {
        Self { left: count }
    }

    /// As much as it takes: for callers that have no ticks.
    pub const fn unlimited() -> Self {
        Self::units(u32::MAX)
    }

    /// Notes that this much was done.
    pub(crate) fn spend(&mut self, units: u32) {
        self.left = self.left.saturating_sub(units);
    }

    /// May more be done?
    pub fn is_left(&self) -> bool {
        self.left > 0
    }
}
