//! The node with a clock at its side.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::Header;
use tactus_common::limits::SILENCE_TICKS_MAX;
use tactus_common::message::{Phase, node};
use tactus_controller::node::Node;

/// Without a frame of the world for so long, the world is gone: 2 s (a world that is planning sends keep-alives).
pub const SILENCE_MS: u32 = 2_000;

/// The node, and when it last heard of the world. Time is the board's milliseconds, which may wrap.
#[derive(Clone, Debug)]
pub struct Shell {
    node: Node,
    /// When the world was last heard, while that matters: a mission is under way.
    heard_ms: Option<u32>,
}

impl Shell {
    /// A node that sends frames of this format.
    pub fn new(mtu: Mtu) -> Self {
        Self { node: Node::new(mtu), heard_ms: None }
    }

    /// The node.
    pub fn node(&self) -> &Node {
        &self.node
    }

    /// Takes a frame; `send` gets the frames that it brings forth. `true` if the controller ticked.
    pub fn receive(&mut self, now_ms: u32, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) -> bool {
        let ticked = self.node.receive(frame, send);
        let of_world = Header::of(frame).is_ok_and(|header| header.source.get() == node::WORLD);
        if ticked || (of_world && self.heard_ms.is_some()) {
            self.heard_ms = Some(now_ms);
        }
        ticked
    }

    /// For when there is no frame to take, at least every few milliseconds: makes the controller safe once the world
    /// is silent.
    pub fn idle(&mut self, now_ms: u32, send: &mut dyn FnMut(CanFrame)) {
        let silent = self.heard_ms.is_some_and(|heard_ms| now_ms.wrapping_sub(heard_ms) >= SILENCE_MS);
        if !silent {
            return;
        }
        self.heard_ms = None;
        for _ in 0..SILENCE_TICKS_MAX {
            if self.node.controller().phase() == Phase::Fault {
                break;
            }
            self.node.silent_tick(send);
        }
    }
}
