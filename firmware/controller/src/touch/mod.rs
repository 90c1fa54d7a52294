//! Touches: which there are, and which to make next.

pub mod candidates;
pub mod choose;
mod clear;
pub mod layout;
#[cfg(test)]
pub(crate) mod rehearse;

pub use candidates::{CANDIDATES, candidate};
pub use choose::{Choice, Chooser, RankedTouches, TouchHistory};

use nalgebra::Isometry3;
use tactus_common::limits::FINGERS;
use tactus_common::message::{HandPlacement, Preshape};
use tactus_common::pose::PlanarPose;
use tactus_common::shape::ObjectShape;

/// A finger that comes this far without feeling anything has missed, radians.
pub const CLOSED_RAD: f32 = 1.75;

/// A touch: where the hand goes down, pointing straight down, how it is opened, and which fingers close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchPlan {
    /// Number of the candidate.
    pub id: u8,
    /// The hand's axis and yaw in the object's frame, metres and radians; at yaw 0 the hand's +x (the side of F1 and
    /// F2) is the object's +x.
    pub hand_in_object: PlanarPose,
    /// Height of the palm's face above the object's top, metres.
    pub palm_height_m: f32,
    /// Spread, radians.
    pub spread_rad: f32,
    /// Inner angles F1, F2, F3 on the way down, radians.
    pub preopen_rad: [f32; FINGERS],
    /// Which fingers close.
    pub closes: [bool; FINGERS],
}

impl TouchPlan {
    /// Where the hand goes, relative to the object.
    pub fn placement(&self) -> HandPlacement {
        HandPlacement { hand_in_object: self.hand_in_object, palm_height_m: self.palm_height_m }
    }

    /// The fingers on the way down.
    pub fn preshape(&self) -> Preshape {
        Preshape { inner_rad: self.preopen_rad, spread_rad: self.spread_rad }
    }

    /// World-from-hand transform at the bottom of the descent for an object believed at `object`: z straight down.
    pub fn world_from_hand(&self, object: &PlanarPose, shape: &ObjectShape) -> Isometry3<f32> {
        self.placement().world_from_hand(object, shape)
    }
}
