//! The load of a bus that does not tell it: frames that were seen, with their exact bit times, one after another.

use crate::bit_time::{BitRates, wire_bits};
use crate::load_window::LoadWindow;
use tactus_common::can::CanFrame;

/// Counts frames and how long they keep a wire busy.
#[derive(Clone, Debug)]
pub struct BusMeter {
    rates: BitRates,
    load: LoadWindow,
    /// When the wire is free again.
    free_ns: u64,
    frames: u64,
}

impl BusMeter {
    /// A wire of these bit rates at time 0.
    pub fn new(rates: BitRates) -> Self {
        Self { rates, load: LoadWindow::default(), free_ns: 0, frames: 0 }
    }

    /// The next frames come at `time_ns`, or as soon as the wire is free.
    pub fn advance_to(&mut self, time_ns: u64) {
        self.free_ns = self.free_ns.max(time_ns);
    }

    /// A frame passes.
    pub fn carry(&mut self, frame: &CanFrame) {
        let end_ns = self.free_ns + wire_bits(frame).duration_ns(self.rates);
        self.load.busy(self.free_ns, end_ns);
        self.free_ns = end_ns;
        self.frames += 1;
    }

    /// Frames so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Largest share of busy time in any 100 ms, 0..1.
    pub fn load_max(&self) -> f64 {
        self.load.load_max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::Bus;
    use crate::virtual_bus::{VirtualBus, VirtualBusConfig};
    use tactus_common::can::Mtu;

    #[test]
    fn frames_at_periods_give_the_load_that_the_virtual_bus_measures() {
        let mut bus = VirtualBus::new(2, VirtualBusConfig::FD);
        let mut meter = BusMeter::new(BitRates::M1_5);
        for period in 0..200_u64 {
            bus.advance_to(period * 2_000_000);
            meter.advance_to(period * 2_000_000);
            for n in 0..3 {
                let frame = CanFrame::new(n, &[period as u8; 48], Mtu::Fd).unwrap();
                bus.endpoint(0).send(frame).unwrap();
                meter.carry(&frame);
            }
            bus.run_until_idle();
        }
        assert_eq!(meter.frames(), bus.stats().frames);
        assert!((meter.load_max() - bus.stats().load_max).abs() < 1e-9);
        assert!(meter.load_max() > 0.1);
    }
}
