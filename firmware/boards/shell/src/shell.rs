//! The node with a clock at its side.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::Header;
use tactus_common::limits::{SILENCE_TICKS_MAX, TICK_US};
use tactus_common::link::WORLD;
use tactus_common::message::Phase;
use tactus_controller::node::Node;

/// Without a frame of the world for so long, the world is gone: 2 s (a world that is planning sends keep-alives).
pub const SILENCE_MS: u32 = 2_000;
/// A node without a mission says so this often: 1 Hz.
pub const ANNOUNCEMENT_MS: u32 = 1_000;

/// The same where ticks come by the clock: 20 periods.
pub const REALTIME_SILENCE_MS: u32 = SILENCE_TICKS_MAX * TICK_US / 1_000;

/// The node, and when it last heard and spoke. Time is the board's milliseconds, which may wrap.
#[derive(Clone, Debug)]
pub struct Shell {
    node: Node,
    silence_ms: u32,
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
        Self::with_silence(mtu, SILENCE_MS)
    }

    /// A node that sends frames of this format and gives the world up after `silence_ms` milliseconds without a frame.
    pub fn with_silence(mtu: Mtu, silence_ms: u32) -> Self {
        Self { node: Node::new(mtu), silence_ms, heard_ms: None, announced_ms: None, uptime_s: 0 }
    }

    /// The node.
    pub fn node(&self) -> &Node {
        &self.node
    }

    /// Shows this node's id on the bus without announcing it: another node that bears it will answer.
    pub fn claim(&mut self, send: &mut dyn FnMut(CanFrame)) {
        self.node.beat(self.uptime_s, send);
    }

    /// Takes a frame; `send` gets the frames that it brings forth. `true` if the controller ticked.
    pub fn receive(&mut self, now_ms: u32, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) -> bool {
        let ticked = self.node.receive(frame, send);
        let of_world = Header::of(frame).is_ok_and(|header| header.source == WORLD);
        if ticked || (of_world && self.heard_ms.is_some()) {
            self.heard_ms = Some(now_ms);
        }
        ticked
    }

    /// For when there is no frame to take, at least every few milliseconds: makes the controller safe once the world
    /// is silent, and announces it while it has no mission. `true` if the world was given up just now.
    pub fn idle(&mut self, now_ms: u32, send: &mut dyn FnMut(CanFrame)) -> bool {
        let silent = self.heard_ms.is_some_and(|heard_ms| now_ms.wrapping_sub(heard_ms) >= self.silence_ms);
        if silent {
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
        silent
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
