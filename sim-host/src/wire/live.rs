//! A controller on a bus outside this process.

use super::{Answered, Wire, WireStats};
use anyhow::{Context, bail};
use std::sync::mpsc;
use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Sender, Session, received_bytes};
use tactus_common::limits::TICK_US;
use tactus_common::link::{self, CONTROLLER, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::{Heartbeat, Hello, SCHEMA_VERSION};
use tactus_hil::bit_time::BitRates;
use tactus_hil::bus::{LiveBus, LiveStats, Refusal, SendOnly};
use tactus_hil::bus_meter::BusMeter;

/// How long the world waits on a CAN bus for the answer to one tick before it takes the controller for lost.
const PATIENCE: Duration = Duration::from_secs(2);
/// Period of the heartbeats of a world that is busy: four within the controller's own patience.
const KEEP_ALIVE: Duration = Duration::from_millis(500);
/// A controller that was started anew counts its announcements from 0 again: below their period of 1 s.
const HELLO_TIMEOUT_MS: u64 = 500;
/// Wait before a refused frame is tried again.
const RETRY: Duration = Duration::from_micros(200);

/// A live bus with, somewhere on it, a controller.
pub struct Live {
    name: String,
    bus: Box<dyn LiveBus>,
    meter: BusMeter,
    /// What the bus had suffered before this mission.
    before: LiveStats,
    opened: Instant,
    hello: Session<{ received_bytes(SMALL_BYTES, Mtu::Fd) }>,
    heartbeat: Option<(Box<dyn SendOnly>, Sender<1>)>,
    beats: u32,
    sent_at: Instant,
}

impl Live {
    /// A bus of this name, open.
    ///
    /// # Errors
    /// The bus gives no second access for the keep-alives.
    pub fn new(name: String, bus: Box<dyn LiveBus>) -> anyhow::Result<Self> {
        let sender = bus.sender().with_context(|| format!("--bus {name}: no second access"))?;
        Ok(Self {
            name,
            before: bus.stats(),
            bus,
            meter: BusMeter::new(BitRates::M1_5),
            hello: Session::new(subject::<Hello>(), CONTROLLER, HELLO_TIMEOUT_MS),
            opened: Instant::now(),
            heartbeat: Some((sender, Sender::new(WORLD, [subject::<Heartbeat>()]))),
            beats: 0,
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
        let started = Instant::now();
        loop {
            match self.bus.send(frame) {
                Ok(()) => break,
                Err(rejected) if rejected.reason == Refusal::Format || started.elapsed() >= self.patience() => {
                    return Err(rejected).with_context(|| self.name.clone());
                }
                // A full queue empties, and an interface that is down may come up again.
                Err(_) => std::thread::sleep(RETRY),
            }
        }
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

    fn busy(&mut self, work: &mut (dyn FnMut() + Send)) {
        let Some((mut sender, mut counter)) = self.heartbeat.take() else { return work() };
        let (mtu, mut beats) = (self.bus.mtu(), self.beats);
        let (done, stop) = mpsc::channel::<()>();
        let kept = std::thread::scope(|scope| {
            let keeper = scope.spawn(move || {
                while stop.recv_timeout(KEEP_ALIVE) == Err(mpsc::RecvTimeoutError::Timeout) {
                    beats += 1;
                    let beat = Heartbeat { uptime_s: beats.to_le_bytes(), health: 0, mode: 0, vendor: 0 };
                    let mut buffer = [0; SMALL_BYTES];
                    if let Ok(bytes) = link::encode(&beat, &mut buffer)
                        && let Ok(frames) = counter.send(subject::<Heartbeat>(), priority::<Heartbeat>(), bytes, mtu)
                    {
                        // A heartbeat that does not get through is one beat less.
                        frames.for_each(|frame| {
                            let _ = sender.send(frame);
                        });
                    }
                }
                (sender, counter, beats)
            });
            work();
            drop(done);
            keeper.join()
        });
        if let Ok((sender, counter, beats)) = kept {
            self.heartbeat = Some((sender, counter));
            self.beats = beats;
        }
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
