//! Going away from the object, as every touch and every failed grasp ends: open the fingers, go back up.

use super::{Tools, hand};
use crate::executor::Motion;
use tactus_common::message::Preshape;

/// Most ticks to open the fingers: 3 s. Fingers that do not open then come up as they are.
const OPENING_TICKS_MAX: u32 = 1_500;
/// The way up is this much faster than the guarded way down.
pub const RETURN_RATE: f32 = 3.0;

/// A withdrawal under way.
#[derive(Clone, Copy, Debug)]
pub enum Withdraw {
    /// Opens.
    Opening {
        /// Ticks since it began.
        ticks: u32,
    },
    /// Goes back up.
    Rising,
}

impl Withdraw {
    /// A withdrawal that opens the fingers first.
    pub const OPEN_FIRST: Self = Self::Opening { ticks: 0 };

    /// A withdrawal with the fingers as they are; the arm stands.
    pub(super) fn at_once(tools: &mut Tools) -> Self {
        tools.executor.go_back(RETURN_RATE);
        Self::Rising
    }

    /// One tick, opening to `preshape`; `true` once the hand is above again.
    pub(super) fn step(&mut self, preshape: &Preshape, tools: &mut Tools) -> bool {
        match self {
            Self::Opening { ticks } => {
                if hand::preshape(preshape, tools) || *ticks >= OPENING_TICKS_MAX {
                    *self = Self::at_once(tools);
                } else {
                    *ticks += 1;
                }
                false
            }
            Self::Rising => tools.executor.motion() == Motion::Holding,
        }
    }
}
