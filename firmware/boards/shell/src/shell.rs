//! The node with a clock at its side.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::Header;
use tactus_common::limits::{SILENCE_TICKS_MAX, TICK_US};
use tactus_common::link::WORLD;
use tactus_common::message::Phase;
use tactus_controller::node::Node;

/// Without a frame of the world for so long, the world is gone: 2 s (a world that is planning sends keep-alives).
pub const SILENCE_MS: u32 = 2_000;
/// With real-time pacing the world is gone after 20 periods without readings, whatever else it says: 40 ms.
pub const REAL_TIME_SILENCE_MS: u32 = SILENCE_TICKS_MAX * TICK_US / 1_000;
/// A node without a mission says so this often: 1 Hz.
pub const ANNOUNCEMENT_MS: u32 = 1_000;

/// Who keeps time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// The world, which waits for every command and may pause: a simulation.
    Lockstep,
    /// The clock: readings come every period or something is wrong. A robot.
    RealTime,
}

/// The node, and when it last heard and spoke. Time is the board's milliseconds, which may wrap.
#[derive(Clone, Debug)]
pub struct Shell {
    node: Node,
    pace: Pace,
    /// When the world was last heard, while that matters: ticks have come since it was last given up.
    heard_ms: Option<u32>,
    /// When the node was last announced.
    announced_ms: Option<u32>,
    /// Announcements so far: seconds since the start, near enough.
    uptime_s: u32,
}

impl Shell {
    /// A node that sends frames of this format, in lockstep with its world.
    pub fn new(mtu: Mtu) -> Self {
        Self::paced(mtu, Pace::Lockstep)
    }

    /// A node that sends frames of this format at this pace.
    pub fn paced(mtu: Mtu, pace: Pace) -> Self {
        Self { node: Node::new(mtu), pace, heard_ms: None, announced_ms: None, uptime_s: 0 }
    }

    /// The node.
    pub fn node(&self) -> &Node {
        &self.node
    }

    /// Takes a frame; `send` gets the frames that it brings forth. `true` if the controller ticked.
    pub fn receive(&mut self, now_ms: u32, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) -> bool {
        let ticked = self.node.receive(frame, send);
        let of_world = Header::of(frame).is_ok_and(|header| header.source == WORLD);
        let lives = of_world && self.pace == Pace::Lockstep && self.heard_ms.is_some();
        if ticked || lives {
            self.heard_ms = Some(now_ms);
        }
        ticked
    }

    /// For when there is no frame to take, at least every few milliseconds: makes the controller safe once the world
    /// is silent, and announces it while it has no mission.
    pub fn idle(&mut self, now_ms: u32, send: &mut dyn FnMut(CanFrame)) {
        let silence_ms = match self.pace {
            Pace::Lockstep => SILENCE_MS,
            Pace::RealTime => REAL_TIME_SILENCE_MS,
        };
        if self.heard_ms.is_some_and(|heard_ms| now_ms.wrapping_sub(heard_ms) >= silence_ms) {
            self.heard_ms = None;
            self.give_up(send);
        }
        let due = self.announced_ms.is_none_or(|announced| now_ms.wrapping_sub(announced) >= ANNOUNCEMENT_MS);
        if due {
            self.announced_ms = Some(now_ms);
            if self.heard_ms.is_none() || self.node.is_free() {
                self.node.announce(self.uptime_s, send);
            }
            self.uptime_s = self.uptime_s.saturating_add(1);
        }
    }

    /// The world is gone: ticks without readings until the controller is safe, if it has not reached its end.
    fn give_up(&mut self, send: &mut dyn FnMut(CanFrame)) {
        for _ in 0..SILENCE_TICKS_MAX {
            if self.node.is_free() || self.node.controller().phase() == Phase::Fault {
                break;
            }
            self.node.silent_tick(send);
        }
        self.node.forget_world();
    }
}

#[cfg(test)]
mod tests;
