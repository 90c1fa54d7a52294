//! A CAN bus within the process: what a wire with two or more controllers on it does, in time that the caller makes pass.
//!
//! * Arbitration: whenever the wire is free, the lowest identifier among the endpoints' next frames is sent. An
//!   endpoint's own queue is kept in order of identifiers too, as a controller with priority mailboxes does, so that a
//!   long transfer does not hold up an urgent one; equal identifiers keep their order.
//! * Time: each frame takes its exact bits ([`crate::bit_time`]) and arrives at all other endpoints at its last bit.
//! * Memory: queues are bounded and allocated once. A full transmit queue hands the frame back, a full receive queue
//!   loses the new frame; both are counted.
//! * Faults: none unless asked for; then drawn from a seed.
//!
//! Equal calls give equal results to the nanosecond.

mod faults;
mod queue;

pub use faults::Faults;
use faults::{Fate, FaultDice};
use queue::TransmitQueue;

use crate::bit_time::{BitRates, INTERMISSION_BITS, wire_bits};
use crate::bus::{Bus, Received, Refusal, Rejected};
use crate::load_window::LoadWindow;
use std::collections::VecDeque;
use tactus_common::can::{CanFrame, Mtu};

/// Bits by which a node tells all others that a frame was damaged: error flags of two nodes and the delimiter.
const ERROR_FRAME_BITS: u32 = 6 + 6 + 8;

/// Properties of a [`VirtualBus`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualBusConfig {
    /// Frame format in which to send. A bus of CAN 2.0 refuses CAN FD frames; one of CAN FD carries both.
    pub mtu: Mtu,
    /// Bit rates.
    pub rates: BitRates,
    /// Frames that each endpoint's transmit queue holds. 128 hold the longest CAN FD transfer (70) with room to spare;
    /// CAN 2.0 cuts that into 629.
    pub transmit_frames: usize,
    /// Frames that each endpoint's receive queue holds.
    pub receive_frames: usize,
    /// Faults.
    pub faults: Faults,
}

impl VirtualBusConfig {
    /// The native bus: CAN FD at 1/5 Mbit/s, without faults.
    pub const FD: Self =
        Self { mtu: Mtu::Fd, rates: BitRates::M1_5, transmit_frames: 128, receive_frames: 256, faults: Faults::NONE };
    /// CAN 2.0 at 1 Mbit/s, without faults.
    pub const CLASSIC: Self = Self { mtu: Mtu::Classic, transmit_frames: 1_024, receive_frames: 2_048, ..Self::FD };
}

/// What the wire has carried.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BusStats {
    /// Frames sent, repetitions included.
    pub frames: u64,
    /// Their bits, with stuff bits and intermissions.
    pub bits: u64,
    /// Time for which the wire was busy, nanoseconds.
    pub busy_ns: u64,
    /// Largest share of busy time in any 100 ms (see [`LoadWindow`]).
    pub load_max: f64,
    /// Frames sent again after an injected fault.
    pub repeated: u64,
    /// Times at which two endpoints sent the same identifier at once: an error of whoever gave out the numbers. The
    /// endpoint with the lower index was let through.
    pub collisions: u64,
}

/// What one endpoint has done and suffered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EndpointStats {
    /// Frames taken for sending.
    pub accepted: u64,
    /// Frames handed back.
    pub rejected: u64,
    /// Frames that arrived in the receive queue.
    pub received: u64,
    /// Frames that found the receive queue full.
    pub overrun: u64,
    /// Frames that an injected fault kept from arriving.
    pub lost: u64,
    /// Most frames that waited for sending at once.
    pub transmit_high_water: usize,
    /// Most frames that waited for being fetched at once.
    pub receive_high_water: usize,
}

struct Node {
    transmit: TransmitQueue,
    receive: VecDeque<Received>,
    stats: EndpointStats,
}

/// The frame on the wire.
struct OnTheWire {
    from: usize,
    frame: CanFrame,
    bits: u32,
    fate: Fate,
    start_ns: u64,
    /// Last bit of the frame: receivers have it.
    end_ns: u64,
    /// Intermission is over: the next frame may begin.
    free_ns: u64,
}

/// The bus; see the [module](self).
pub struct VirtualBus {
    config: VirtualBusConfig,
    nodes: Vec<Node>,
    now_ns: u64,
    /// When the wire becomes free.
    free_ns: u64,
    wire: Option<OnTheWire>,
    dice: FaultDice,
    load: LoadWindow,
    stats: BusStats,
}

impl VirtualBus {
    /// A bus with `endpoints` endpoints at time 0.
    pub fn new(endpoints: usize, config: VirtualBusConfig) -> Self {
        let node = || Node {
            transmit: TransmitQueue::with_capacity(config.transmit_frames),
            receive: VecDeque::with_capacity(config.receive_frames),
            stats: EndpointStats::default(),
        };
        Self {
            config,
            nodes: (0..endpoints).map(|_| node()).collect(),
            now_ns: 0,
            free_ns: 0,
            wire: None,
            dice: FaultDice::new(config.faults),
            load: LoadWindow::default(),
            stats: BusStats::default(),
        }
    }

    /// The bus's clock, nanoseconds.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Frame format in which to send.
    pub fn mtu(&self) -> Mtu {
        self.config.mtu
    }

    /// Access for endpoint `index`.
    ///
    /// # Panics
    /// If there is no such endpoint.
    pub fn endpoint(&mut self, index: usize) -> Endpoint<'_> {
        assert!(index < self.nodes.len(), "endpoint {index} of {}", self.nodes.len());
        Endpoint { bus: self, index }
    }

    /// What the wire has carried so far.
    pub fn stats(&self) -> BusStats {
        BusStats { load_max: self.load.load_max(), ..self.stats }
    }

    /// What endpoint `index` has done so far.
    ///
    /// # Panics
    /// If there is no such endpoint.
    pub fn endpoint_stats(&self, index: usize) -> EndpointStats {
        self.nodes[index].stats
    }

    /// Lets time pass until `time_ns`: sends what fits, delivers what arrives until then. A time that has passed
    /// already changes nothing.
    pub fn advance_to(&mut self, time_ns: u64) {
        if time_ns < self.now_ns {
            return;
        }
        self.begin();
        while self.wire.as_ref().is_some_and(|wire| wire.end_ns <= time_ns) {
            self.finish();
        }
        self.now_ns = time_ns;
    }

    /// Lets time pass until all queues are empty and the last frame has arrived; how long that took, nanoseconds.
    pub fn run_until_idle(&mut self) -> u64 {
        let start_ns = self.now_ns;
        self.begin();
        while self.wire.is_some() {
            self.finish();
        }
        self.now_ns - start_ns
    }

    /// If the wire is idle: arbitration, and the winner's frame on the wire.
    fn begin(&mut self) {
        if self.wire.is_some() {
            return;
        }
        let heads = || self.nodes.iter().map(|node| node.transmit.front().map(CanFrame::arbitration)).enumerate();
        let Some((lowest, from)) = heads().filter_map(|(index, head)| Some((head?, index))).min() else { return };
        let contenders = heads().filter(|(_, head)| *head == Some(lowest));
        self.stats.collisions += contenders.count() as u64 - 1;
        let Some(frame) = self.nodes[from].transmit.pop() else { return };

        let fate = self.dice.fate();
        let wire_bits = wire_bits(&frame);
        let error_bits = if fate == Fate::Damaged { ERROR_FRAME_BITS } else { 0 };
        let nominal_ns = u64::from(self.config.rates.nominal_bit_ns);
        // Whatever waits was queued at `now_ns` at the latest, so the wire has not been free with a frame waiting.
        let start_ns = self.free_ns.max(self.now_ns);
        let free_ns = start_ns + wire_bits.duration_ns(self.config.rates) + u64::from(error_bits) * nominal_ns;
        let end_ns = free_ns - u64::from(INTERMISSION_BITS) * nominal_ns;
        self.free_ns = free_ns;
        self.wire =
            Some(OnTheWire { from, frame, bits: wire_bits.total() + error_bits, fate, start_ns, end_ns, free_ns });
    }

    /// The frame on the wire arrives; the next one begins.
    fn finish(&mut self) {
        let Some(OnTheWire { from, frame, bits, fate, start_ns, end_ns, free_ns }) = self.wire.take() else { return };
        self.now_ns = self.now_ns.max(end_ns);
        self.stats.frames += 1;
        self.stats.bits += u64::from(bits);
        self.stats.busy_ns += free_ns - start_ns;
        self.load.busy(start_ns, free_ns);
        if fate != Fate::Damaged {
            self.deliver(from, Received { frame, at_ns: end_ns });
        }
        if fate != Fate::Intact {
            self.stats.repeated += 1;
            self.nodes[from].transmit.put_back(frame);
        }
        self.begin();
    }

    fn deliver(&mut self, from: usize, received: Received) {
        let others = self.nodes.iter_mut().enumerate().filter(|(index, _)| *index != from);
        for (_, node) in others {
            if self.dice.loses() {
                node.stats.lost += 1;
            } else if node.receive.len() == self.config.receive_frames {
                node.stats.overrun += 1;
            } else {
                node.receive.push_back(received);
                node.stats.received += 1;
                node.stats.receive_high_water = node.stats.receive_high_water.max(node.receive.len());
            }
        }
    }
}

/// One endpoint's access to a [`VirtualBus`]; made where it is needed, keeps nothing.
pub struct Endpoint<'a> {
    bus: &'a mut VirtualBus,
    index: usize,
}

impl Bus for Endpoint<'_> {
    fn mtu(&self) -> Mtu {
        self.bus.config.mtu
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        let node = &mut self.bus.nodes[self.index];
        let taken = if frame.is_fd() && self.bus.config.mtu == Mtu::Classic {
            Err(Refusal::Format)
        } else {
            node.transmit.push(frame).map_err(|_| Refusal::Full)
        };
        match taken {
            Ok(()) => {
                node.stats.accepted += 1;
                node.stats.transmit_high_water = node.stats.transmit_high_water.max(node.transmit.len());
                Ok(())
            }
            Err(reason) => {
                node.stats.rejected += 1;
                Err(Rejected { frame, reason })
            }
        }
    }

    fn receive(&mut self) -> Option<Received> {
        self.bus.nodes[self.index].receive.pop_front()
    }
}

#[cfg(test)]
mod tests;
