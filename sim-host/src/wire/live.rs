//! A controller on a bus outside this process.

use super::keep_alive::KeepAlive;
use super::{Answered, Wire, WireStats};
use anyhow::{Context, bail};
use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Session, received_bytes};
use tactus_common::limits::TICK_US;
use tactus_common::link::{self, CONTROLLER, SMALL_BYTES, subject};
use tactus_common::message::{Hello, SCHEMA_VERSION};
use tactus_hil::bit_time::BitRates;
use tactus_hil::bus::{LiveBus, LiveStats, send_within};
use tactus_hil::bus_meter::BusMeter;

/// How long the world waits on a CAN bus for the answer to one tick before it takes the controller for lost.
const PATIENCE: Duration = Duration::from_secs(2);
/// A controller that was started anew counts its announcements from 0 again: below their period of 1 s.
const HELLO_TIMEOUT_MS: u64 = 500;
/// A live bus with, somewhere on it, a controller.
pub struct Live {
    name: String,
    bus: Box<dyn LiveBus>,
    meter: BusMeter,
    /// What the bus had suffered before this mission.
    before: LiveStats,
    opened: Instant,
    hello: Session<{ received_bytes(SMALL_BYTES, Mtu::Fd) }>,
    keep_alive: KeepAlive,
    sent_at: Instant,
}

impl Live {
    /// A bus of this name, open.
    ///
    /// # Errors
    /// The bus gives no second access for the keep-alives.
    pub fn new(name: String, bus: Box<dyn LiveBus>) -> anyhow::Result<Self> {
        let sender = bus.sender().with_context(|| format!("--bus {name}: no second access"))?;
        let keep_alive = KeepAlive::new(sender, bus.mtu());
        Ok(Self {
            name,
            before: bus.stats(),
            bus,
            meter: BusMeter::new(BitRates::M1_5),
            hello: Session::new(subject::<Hello>(), CONTROLLER, HELLO_TIMEOUT_MS),
            opened: Instant::now(),
            keep_alive,
            sent_at: Instant::now(),
        })
    }

    /// The version that a frame announces, if it completes an announcement.
    fn version_in(&mut self, frame: &CanFrame) -> Option<u64> {
        let header = Header::of(frame).ok()?;
        let now_ms = self.opened.elapsed().as_millis() as u64;
        let transfer = self.hello.accept(&header, frame.data(), now_ms).ok()??;
        let hello = link::decode::<Hello>(transfer.payload).ok()?;
        Some(u64::from_le_bytes(hello.schema_version))
    }
}

impl Wire for Live {
    fn mtu(&self) -> Mtu {
        self.bus.mtu()
    }

    fn meet(&mut self, patience: Duration) -> anyhow::Result<bool> {
        let started = Instant::now();
        loop {
            while let Some(received) = self.bus.receive() {
                match self.version_in(&received.frame) {
                    Some(SCHEMA_VERSION) => {
                        self.meter = BusMeter::new(BitRates::M1_5);
                        self.before = self.bus.stats();
                        return Ok(true);
                    }
                    Some(theirs) => bail!(
                        "the controller on {} speaks version {theirs:016x} of the messages, this world \
                         {SCHEMA_VERSION:016x}; build both from the same source",
                        self.name
                    ),
                    None => {}
                }
            }
            let left = patience.saturating_sub(started.elapsed());
            if left.is_zero() {
                return Ok(false);
            }
            self.bus.wait(left);
        }
    }

    fn patience(&self) -> Duration {
        PATIENCE * self.bus.slowness()
    }

    fn send(&mut self, frame: CanFrame) -> anyhow::Result<()> {
        let patience = self.patience();
        send_within(self.bus.as_mut(), frame, patience).with_context(|| self.name.clone())?;
        self.meter.carry(&frame);
        self.sent_at = Instant::now();
        Ok(())
    }

    fn settle(&mut self) {
        // Frames of one sender arrive in the order of sending.
    }

    fn begin_period(&mut self, tick: u32) {
        self.meter.advance_to(u64::from(tick) * u64::from(TICK_US) * 1_000);
    }

    fn answer(
        &mut self,
        _tick: u32,
        until: Instant,
        hear: &mut dyn FnMut(&CanFrame) -> bool,
    ) -> anyhow::Result<Answered> {
        loop {
            while let Some(received) = self.bus.receive() {
                self.meter.carry(&received.frame);
                if hear(&received.frame) {
                    return Ok(Answered { complete: true, took: self.sent_at.elapsed() });
                }
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(Answered { complete: false, took: self.sent_at.elapsed() });
            }
            self.bus.wait(left);
        }
    }

    fn busy(&mut self, work: &mut dyn FnMut()) {
        self.keep_alive.during(work);
    }

    fn stats(&self) -> WireStats {
        let (now, before) = (self.bus.stats(), self.before);
        WireStats {
            frames: self.meter.frames(),
            load_max: self.meter.load_max() as f32,
            lost: now.lost - before.lost,
            foreign: now.foreign + now.errors - before.foreign - before.errors,
            downs: now.downs - before.downs,
        }
    }
}
