//! After the object was lost on the way: let go of nothing, open, go up, and search anew around where it was lost.

use super::{Tools, hand};
use crate::executor::Motion;
use core::f32::consts::FRAC_PI_4;
use nalgebra::Vector3;
use tactus_common::limits::FINGERS;
use tactus_common::message::Preshape;
use tactus_common::pose::{Interval, PlanarPose};

/// Ticks that the fingers have for opening: 2 s.
const OPENING_TICKS_MAX: u32 = 1_000;
/// An object that falls from the hand lies within this of the hand's axis.
const AROUND: Interval = Interval { x_m: 0.10, y_m: 0.10, phi_rad: FRAC_PI_4 };

/// How far the recovery is.
pub enum RecoverEnd {
    /// It goes on.
    NotYet,
    /// The fingers are open; the hand may go up.
    Open,
}

/// The recovery under way.
#[derive(Clone, Debug, Default)]
pub struct Recover {
    ticks: u32,
}

impl Recover {
    /// One tick: stop, then open.
    pub(super) fn step(&mut self, tools: &mut Tools) -> RecoverEnd {
        if tools.executor.motion() != Motion::Holding {
            tools.executor.stop();
            return RecoverEnd::NotYet;
        }
        self.ticks += 1;
        let open = Preshape { inner_rad: [0.0; FINGERS], spread_rad: tools.readings.motor_q_rad[FINGERS] };
        if hand::preshape(&open, tools) || self.ticks >= OPENING_TICKS_MAX {
            RecoverEnd::Open
        } else {
            RecoverEnd::NotYet
        }
    }
}

/// Where to search: below the hand, with the yaw that the object had in it.
pub fn search_region(tools: &Tools, yaw_in_hand_rad: f32) -> (PlanarPose, Interval) {
    let world_from_hand = hand::pose(tools);
    (
        PlanarPose::new(
            world_from_hand.translation.x,
            world_from_hand.translation.y,
            hand_yaw_rad(tools) - yaw_in_hand_rad,
        ),
        AROUND,
    )
}

/// Yaw of the hand that points down: direction of its x axis in the world, radians.
pub fn hand_yaw_rad(tools: &Tools) -> f32 {
    let x = hand::pose(tools).rotation * Vector3::x();
    libm::atan2f(x.y, x.x)
}
