//! What a node needs of a bus. [`Bus`]: no clock, no waiting, whoever owns the bus makes time pass. [`LiveBus`]: a bus
//! that lives outside this process, where time passes by itself.

use std::time::Duration;
use tactus_common::can::{CanFrame, Mtu};

/// A frame that arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The frame.
    pub frame: CanFrame,
    /// When its last bit had passed, nanoseconds of the bus's own clock.
    pub at_ns: u64,
}

/// Why a bus did not take a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The transmit queue is full; there will be room once frames have been sent.
    Full,
    /// The bus does not carry this frame format (CAN FD on a CAN 2.0 bus).
    Format,
    /// The bus is gone (interface down, cable pulled).
    Down,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Full => "the transmit queue is full",
            Self::Format => "the bus does not carry CAN FD frames",
            Self::Down => "the bus is down",
        })
    }
}

/// Error returned by [`Bus::send`]: the frame comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rejected {
    /// The frame that was not taken.
    pub frame: CanFrame,
    /// Why.
    pub reason: Refusal,
}

impl std::fmt::Display for Rejected {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "frame {:?} not sent: {}", self.frame, self.reason)
    }
}

impl std::error::Error for Rejected {}

/// One node's access to a bus.
pub trait Bus {
    /// The frame format in which to send on this bus.
    fn mtu(&self) -> Mtu;

    /// Queues a frame for sending. Frames of equal identifier keep their order.
    ///
    /// # Errors
    /// [`Rejected`] with the frame. The caller decides whether to try again or to do without; the bus counts it.
    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected>;

    /// The oldest frame that arrived from other nodes and was not fetched yet; never waits.
    fn receive(&mut self) -> Option<Received>;
}

/// What a [`LiveBus`] has suffered so far, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveStats {
    /// Frames sent.
    pub sent: u64,
    /// Frames fetched.
    pub received: u64,
    /// Frames that the receive queue had no room for, as far as the operating system tells.
    pub lost: u64,
    /// Error frames: the bus's own reports of trouble (bus off, no acknowledgement, ...).
    pub errors: u64,
    /// Frames, or what should have been frames, that are no data frames of ours.
    pub foreign: u64,
    /// Times at which the bus was found down.
    pub downs: u64,
}

/// A node's access to a bus that is not of this process: SocketCAN, a serial line. Frames leave in the order of
/// sending and arrive in the order of their sender's sending.
pub trait LiveBus: Bus + Send {
    /// Waits until [`Bus::receive`] has a frame, at most `timeout`; `true` if there is one. A bus that is down is waited
    /// for in the same way, so that it may come back; [`LiveBus::stats`] counts it.
    fn wait(&mut self, timeout: Duration) -> bool;

    /// Another access to the same bus, which may be used from another thread; it only sends.
    ///
    /// # Errors
    /// The operating system refuses.
    fn sender(&self) -> std::io::Result<Box<dyn SendOnly>>;

    /// What it has suffered.
    fn stats(&self) -> LiveStats;

    /// How many times as long as on a CAN bus one must wait for an answer.
    fn slowness(&self) -> u32 {
        1
    }
}

/// The sending half of a [`LiveBus`].
pub trait SendOnly: Send {
    /// As [`Bus::send`].
    ///
    /// # Errors
    /// As [`Bus::send`].
    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected>;
}

impl<B: Bus + ?Sized> Bus for &mut B {
    fn mtu(&self) -> Mtu {
        (**self).mtu()
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        (**self).send(frame)
    }

    fn receive(&mut self) -> Option<Received> {
        (**self).receive()
    }
}
