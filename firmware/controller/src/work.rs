//! How much long computations may do in one tick.

use tactus_common::shape::ObjectShape;

/// Separation of a link from a box, in units of [`Work`]: what the pieces of work are measured by.
const BOX_SEPARATION: u32 = ObjectShape::THESIS_BOX.separation_cost();
/// Most separations in one indivisible piece: the links of a finger.
const SEPARATIONS_MAX: u32 = 3;
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
    /// Nothing has been done yet.
    untouched: bool,
}

impl Work {
    /// What a tick has to spare besides control and messages: two thirds of its budget of 168,000 instructions.
    pub const PER_TICK: Self = Self::units(750);

    /// So many units.
    pub const fn units(count: u32) -> Self {
        Self { left: count, untouched: true }
    }

    /// As much as it takes: for callers that have no ticks.
    pub const fn unlimited() -> Self {
        Self::units(u32::MAX)
    }

    /// Notes that this much was done.
    pub(crate) fn spend(&mut self, units: u32) {
        self.left = self.left.saturating_sub(units);
        self.untouched = false;
    }

    /// May more be done?
    pub fn is_left(&self) -> bool {
        self.left > 0
    }

    /// May a piece be begun that works out separations from this shape? For those that cost more than a box's, only while
    /// the surplus is left as well, so that the piece that a tick may take more is none the larger; the first of a tick
    /// always.
    pub(crate) fn is_left_for(&self, shape: &ObjectShape) -> bool {
        let surplus = SEPARATIONS_MAX * shape.separation_cost().saturating_sub(BOX_SEPARATION);
        self.left > surplus || (self.untouched && self.left > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_costly_shape_leaves_room_for_its_last_piece_and_goes_on_in_every_tick() {
        let cylinder = ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.1 };
        let mut work = Work::PER_TICK;
        assert!(work.is_left_for(&cylinder));
        work.spend(Work::PER_TICK.left - SEPARATIONS_MAX * (cylinder.separation_cost() - BOX_SEPARATION));
        assert!(!work.is_left_for(&cylinder) && work.is_left_for(&ObjectShape::THESIS_BOX));
        assert!(Work::units(1).is_left_for(&cylinder));
    }
}
