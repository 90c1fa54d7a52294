//! The shell around the controller as a process: a bus, a clock, and nothing that decides anything.

use crate::bus::{LiveBus, send_within};
use crate::choice::Pace;
use std::time::{Duration, Instant};
use tactus_common::can::CanFrame;
use tactus_common::cyphal::Header;
use tactus_common::link::{CONTROLLER, WORLD};
use tactus_common::message::{EventKind, SCHEMA_VERSION};
use tactus_controller::node::NodeStats;
use tactus_shell::{REALTIME_SILENCE_MS, SILENCE_MS};

/// Wait for another node of the same id to answer our first announcement.
const CLAIM: Duration = Duration::from_millis(300);
/// Longest wait between two looks at the clock.
const LOOK: Duration = Duration::from_millis(10);
/// Silence of the world that ends the rest after a mission.
const REST: Duration = Duration::from_millis(200);
/// Patience of a controller that is there for one mission only.
const ONCE_PATIENCE: Duration = Duration::from_secs(30);
/// How long a frame that the bus has no room for is tried again: 20 periods, after which the drives have let go anyway.
const RETRY_FOR: Duration = Duration::from_millis(REALTIME_SILENCE_MS as u64);

/// How the shell behaves.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShellOptions {
    /// What makes the ticks come.
    pub pace: Pace,
    /// End with the first mission.
    pub once: bool,
}

/// Why the shell ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShellEnd {
    /// The one mission is over, whatever came of it.
    MissionOver(EventKind),
    /// The world fell silent during the mission; the robot has been made safe.
    Silence,
    /// Nobody began a mission in time.
    NoWorld,
    /// Another controller is on the bus.
    Twin,
    /// The world speaks another version of the messages.
    Version(u64),
}

/// What the shell tells its owner.
#[derive(Clone, Copy, Debug)]
pub enum Said {
    /// On the bus, waiting for a world.
    Ready,
    /// A mission has begun.
    MissionBegins,
    /// A mission is over: how, after how many ticks, with which digest; the longest tick.
    MissionOver {
        /// How.
        end: EventKind,
        /// Ticks that the digest covers.
        ticks: u32,
        /// The digest.
        digest: u64,
        /// Longest time from the readings' last frame to the command's last frame.
        longest_tick: Duration,
        /// What was no use.
        stats: NodeStats,
    },
    /// The world fell silent for this long; the robot has been made safe.
    Silence(Duration),
    /// Another node bears this node's id; said once.
    Twin,
    /// The world speaks another version.
    Version(u64),
}

/// The controller on a bus.
pub struct Shell<'a> {
    bus: &'a mut dyn LiveBus,
    inner: tactus_shell::Shell,
    once: bool,
    started: Instant,
    /// When the world was last heard.
    heard: Instant,
    running: bool,
    twin_told: bool,
    /// When this node's id was last shown.
    claimed: Option<Instant>,
    longest_tick: Duration,
}

impl<'a> Shell<'a> {
    /// A controller that was just switched on.
    pub fn new(bus: &'a mut dyn LiveBus, options: ShellOptions) -> Self {
        let now = Instant::now();
        let silence_ms = match options.pace {
            Pace::Lockstep => SILENCE_MS,
            Pace::Realtime => REALTIME_SILENCE_MS,
        };
        Self {
            inner: tactus_shell::Shell::with_silence(bus.mtu(), silence_ms),
            bus,
            once: options.once,
            started: now,
            heard: now,
            running: false,
            twin_told: false,
            claimed: None,
            longest_tick: Duration::ZERO,
        }
    }

    /// Serves missions until there is a reason to end; without [`ShellOptions::once`], that is another controller.
    pub fn run(&mut self, tell: &mut dyn FnMut(Said)) -> ShellEnd {
        if !self.claim() {
            tell(Said::Twin);
            return ShellEnd::Twin;
        }
        tell(Said::Ready);
        loop {
            self.bus.wait(LOOK);
            if let Some(end) = self.take(tell).or_else(|| self.watch(tell)) {
                return end;
            }
        }
    }

    /// Milliseconds since the start, as the boards count them.
    fn now_ms(&self) -> u32 {
        self.started.elapsed().as_millis() as u32
    }

    /// Shows this node's id and listens for another node that bears it. `false` if there is one.
    fn claim(&mut self) -> bool {
        self.claim_id();
        let until = Instant::now() + CLAIM;
        loop {
            while let Some(received) = self.bus.receive() {
                if Header::of(&received.frame).is_ok_and(|header| header.source == CONTROLLER) {
                    return false;
                }
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return true;
            }
            self.bus.wait(left);
        }
    }

    /// Hands a frame to the controller; `true` if it ticked.
    fn hand_over(&mut self, frame: &CanFrame) -> bool {
        let now_ms = self.now_ms();
        let bus = &mut self.bus;
        self.inner.receive(now_ms, frame, &mut |frame| send(*bus, frame))
    }

    /// Takes what has arrived.
    fn take(&mut self, tell: &mut dyn FnMut(Said)) -> Option<ShellEnd> {
        while let Some(received) = self.bus.receive() {
            let Ok(header) = Header::of(&received.frame) else { continue };
            if header.source == CONTROLLER {
                self.meet_twin(tell);
            }
            if header.source == WORLD {
                self.heard = Instant::now();
            }
            let was_free = self.inner.node().is_free();
            let began = Instant::now();
            if self.hand_over(&received.frame)
                && let Some(end) = self.ticked(was_free, began.elapsed(), tell)
            {
                return Some(end);
            }
        }
        None
    }

    /// After a tick: did a mission begin or end?
    fn ticked(&mut self, was_free: bool, took: Duration, tell: &mut dyn FnMut(Said)) -> Option<ShellEnd> {
        let free = self.inner.node().is_free();
        if was_free && !free {
            self.running = true;
            self.longest_tick = Duration::ZERO;
            tell(Said::MissionBegins);
        }
        self.longest_tick = self.longest_tick.max(took);
        if let Some(version) = self.inner.node().foreign_version().filter(|_| was_free) {
            tell(Said::Version(version));
            return self.once.then_some(ShellEnd::Version(version));
        }
        if !self.running || !free {
            return None;
        }
        self.running = false;
        let end = self.tell_end(tell)?;
        if !self.once {
            return None;
        }
        self.rest();
        Some(ShellEnd::MissionOver(end))
    }

    /// Another controller speaks: it shall hear that it is not alone.
    fn meet_twin(&mut self, tell: &mut dyn FnMut(Said)) {
        if !self.twin_told {
            self.twin_told = true;
            tell(Said::Twin);
        }
        // Two that met while both were running must not answer each other's answers without end.
        if self.claimed.is_none_or(|at| at.elapsed() >= CLAIM / 10) {
            self.claim_id();
        }
    }

    fn claim_id(&mut self) {
        self.claimed = Some(Instant::now());
        let bus = &mut self.bus;
        self.inner.claim(&mut |frame| send(*bus, frame));
    }

    fn tell_end(&self, tell: &mut dyn FnMut(Said)) -> Option<EventKind> {
        let node = self.inner.node();
        let (end, report) = node.end()?;
        tell(Said::MissionOver {
            end,
            ticks: report.ticks,
            digest: u64::from_le_bytes(report.digest),
            longest_tick: self.longest_tick,
            stats: node.stats(),
        });
        Some(end)
    }

    /// The robot comes to rest under this controller until the world falls silent.
    fn rest(&mut self) {
        while self.heard.elapsed() < REST {
            self.bus.wait(LOOK);
            while let Some(received) = self.bus.receive() {
                self.heard = Instant::now();
                self.hand_over(&received.frame);
            }
        }
    }

    /// Looks at the clock.
    fn watch(&mut self, tell: &mut dyn FnMut(Said)) -> Option<ShellEnd> {
        let silent_for = self.heard.elapsed();
        let now_ms = self.now_ms();
        let bus = &mut self.bus;
        let given_up = self.inner.idle(now_ms, &mut |frame| send(*bus, frame));
        if given_up && self.running {
            self.running = false;
            tell(Said::Silence(silent_for));
            self.tell_end(tell);
            return self.once.then_some(ShellEnd::Silence);
        }
        let in_vain = self.once && !self.running && silent_for >= ONCE_PATIENCE;
        in_vain.then_some(ShellEnd::NoWorld)
    }
}

/// Sends a frame. One that the bus does not take in time is lost, as on the wire; the world asks again.
fn send(bus: &mut dyn LiveBus, frame: CanFrame) {
    let _ = send_within(bus, frame, RETRY_FOR);
}

impl std::fmt::Display for Said {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ready => f.write_str("ready, waiting for a world"),
            Self::MissionBegins => f.write_str("mission begins"),
            Self::MissionOver { end, ticks, digest, longest_tick, stats } => write!(
                f,
                "mission over: {end:?}; {ticks} ticks, digest {digest:016x}, longest tick {} us, {} frames bad, {} \
                 implausible, {} transfers missed",
                longest_tick.as_micros(),
                stats.bad_frames + stats.bad_payloads,
                stats.implausible,
                stats.missed
            ),
            Self::Silence(silence) => write!(
                f,
                "no frame from the world for {:.3} s: the robot is made safe, commands are without torque",
                silence.as_secs_f32()
            ),
            Self::Twin => write!(f, "another controller with node id {} is on this bus", CONTROLLER.get()),
            Self::Version(theirs) => write!(
                f,
                "the world speaks version {theirs:016x} of the messages, this controller {SCHEMA_VERSION:016x}; build \
                 both from the same source"
            ),
        }
    }
}
