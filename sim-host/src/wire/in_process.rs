//! The controller in this process, at the other end of a virtual bus.

use super::{Answered, Wire, WireStats};
use crate::hooks::{Hooks, To};
use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::limits::TICK_US;
use tactus_controller::node::Node;
use tactus_hil::bus::Bus;
use tactus_hil::virtual_bus::{VirtualBus, VirtualBusConfig};

/// Places on the virtual bus.
const WORLD: usize = 0;
const CONTROLLER: usize = 1;

/// A virtual bus with the controller's node at its other end.
pub struct InProcess {
    bus: VirtualBus,
    node: Node,
    hooks: Hooks,
}

impl InProcess {
    /// A controller that was just switched on, on a bus of this frame format.
    pub fn new(mtu: Mtu, hooks: Hooks) -> Self {
        let native = match mtu {
            Mtu::Fd => VirtualBusConfig::FD,
            Mtu::Classic => VirtualBusConfig::CLASSIC,
        };
        let config = VirtualBusConfig { faults: hooks.faults, ..native };
        Self { bus: VirtualBus::new(2, config), node: Node::new(mtu), hooks }
    }

    /// The controller's node, for reports: nobody at the world's end may act on what is in it.
    pub fn node(&self) -> &Node {
        &self.node
    }

    /// Lets the controller take what has arrived, and puts what it says on the bus.
    fn run_controller(&mut self, tick: u32) -> anyhow::Result<Duration> {
        let started = Instant::now();
        let mut said: Vec<CanFrame> = Vec::new();
        let mut ticked = false;
        while let Some(received) = self.bus.endpoint(CONTROLLER).receive() {
            for frame in self.hooks.pass(tick, To::Controller, received.frame) {
                ticked |= self.node.receive(&frame, &mut |frame| said.push(frame));
            }
        }
        if !ticked {
            // The period is over and no sensor message has come.
            self.node.silent_tick(&mut |frame| said.push(frame));
        }
        let took = started.elapsed();
        for frame in said {
            self.bus.endpoint(CONTROLLER).send(frame)?;
        }
        Ok(took)
    }
}

impl Wire for InProcess {
    fn mtu(&self) -> Mtu {
        self.bus.mtu()
    }

    fn meet(&mut self, _patience: Duration) -> anyhow::Result<bool> {
        Ok(true)
    }

    fn patience(&self) -> Duration {
        Duration::ZERO
    }

    fn send(&mut self, frame: CanFrame) -> anyhow::Result<()> {
        Ok(self.bus.endpoint(WORLD).send(frame)?)
    }

    fn settle(&mut self) {
        // On this bus the frame with the higher priority overtakes, so what must be first must not wait beside it.
        self.bus.run_until_idle();
    }

    fn begin_period(&mut self, tick: u32) {
        // Periods begin on the bus's own clock, so that its load is that of a bus at 500 Hz.
        self.bus.advance_to(u64::from(tick) * u64::from(TICK_US) * 1_000);
        self.bus.run_until_idle();
    }

    fn answer(
        &mut self,
        tick: u32,
        _until: Instant,
        hear: &mut dyn FnMut(&CanFrame) -> bool,
    ) -> anyhow::Result<Answered> {
        let took = self.run_controller(tick)?;
        self.bus.run_until_idle();
        let mut complete = false;
        while let Some(received) = self.bus.endpoint(WORLD).receive() {
            for frame in self.hooks.pass(tick, To::World, received.frame) {
                complete |= hear(&frame);
            }
        }
        Ok(Answered { complete, took })
    }

    fn busy(&mut self, work: &mut dyn FnMut()) {
        work();
    }

    fn stats(&self) -> WireStats {
        let stats = self.bus.stats();
        let lost = [WORLD, CONTROLLER]
            .map(|e| self.bus.endpoint_stats(e))
            .iter()
            .map(|s| s.rejected + s.overrun + s.lost)
            .sum();
        WireStats { frames: stats.frames, load_max: stats.load_max as f32, lost, ..WireStats::default() }
    }
}
