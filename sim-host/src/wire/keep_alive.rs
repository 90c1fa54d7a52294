//! Heartbeats of a world that is busy.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;
use tactus_common::can::Mtu;
use tactus_common::cyphal::Sender;
use tactus_common::link::{self, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::Heartbeat;
use tactus_hil::bus::SendOnly;

/// Period: four within the controller's own patience.
const PERIOD: Duration = Duration::from_millis(500);

/// The world's heartbeats on a live bus.
pub struct KeepAlive {
    bus: Box<dyn SendOnly>,
    mtu: Mtu,
    counter: Sender<1>,
    /// Heartbeats so far.
    beats: u32,
}

impl KeepAlive {
    /// Heartbeats in frames of this format; none is sent yet.
    pub fn new(bus: Box<dyn SendOnly>, mtu: Mtu) -> Self {
        Self { bus, mtu, counter: Sender::new(WORLD, [subject::<Heartbeat>()]), beats: 0 }
    }

    /// Does `work`, with a heartbeat each half second that it takes.
    pub fn during(&mut self, work: &mut dyn FnMut()) {
        let (done, stop) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                while stop.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                    self.beat();
                }
            });
            work();
            drop(done);
        });
    }

    fn beat(&mut self) {
        self.beats += 1;
        let beat = Heartbeat { uptime_s: self.beats.to_le_bytes(), health: 0, mode: 0, vendor: 0 };
        let mut buffer = [0; SMALL_BYTES];
        if let Ok(bytes) = link::encode(&beat, &mut buffer)
            && let Ok(frames) = self.counter.send(subject::<Heartbeat>(), priority::<Heartbeat>(), bytes, self.mtu)
        {
            // One that does not get through is one beat less.
            frames.for_each(|frame| {
                let _ = self.bus.send(frame);
            });
        }
    }
}
