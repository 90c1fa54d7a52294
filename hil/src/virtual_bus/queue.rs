//! Frames that wait for the wire.

use std::collections::VecDeque;
use tactus_common::can::CanFrame;

/// A bounded queue in order of identifiers; frames of equal identifier keep their order.
pub(super) struct TransmitQueue {
    frames: VecDeque<CanFrame>,
    capacity: usize,
}

impl TransmitQueue {
    pub(super) fn with_capacity(capacity: usize) -> Self {
        // One more: a frame that is put back may find its place taken.
        Self { frames: VecDeque::with_capacity(capacity + 1), capacity }
    }

    pub(super) fn len(&self) -> usize {
        self.frames.len()
    }

    pub(super) fn front(&self) -> Option<&CanFrame> {
        self.frames.front()
    }

    pub(super) fn pop(&mut self) -> Option<CanFrame> {
        self.frames.pop_front()
    }

    /// Behind all frames that are as urgent; the frame itself if the queue is full.
    pub(super) fn push(&mut self, frame: CanFrame) -> Result<(), CanFrame> {
        if self.frames.len() >= self.capacity {
            return Err(frame);
        }
        let place = self.frames.partition_point(|waiting| waiting.arbitration() <= frame.arbitration());
        self.frames.insert(place, frame);
        Ok(())
    }

    /// Before all frames that are as urgent: it was sent and must be sent again.
    pub(super) fn put_back(&mut self, frame: CanFrame) {
        let place = self.frames.partition_point(|waiting| waiting.arbitration() < frame.arbitration());
        self.frames.insert(place, frame);
    }
}
