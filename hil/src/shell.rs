//! The shell around the controller as a process: a bus, a clock, and nothing that decides anything.

use crate::bus::LiveBus;
use std::time::{Duration, Instant};
use tactus_common::can::CanFrame;
use tactus_common::cyphal::Header;
use tactus_common::limits::{SILENCE_TICKS_MAX, TICK_US};
use tactus_common::link::{CONTROLLER, WORLD};
use tactus_common::message::{EventKind, SCHEMA_VERSION};
use tactus_controller::node::{Node, NodeStats};

/// Wait for another node of the same id to answer our first announcement.
const CLAIM: Duration = Duration::from_millis(300);
/// Period of announcements.
const ANNOUNCE: Duration = Duration::from_secs(1);
/// Silence after which a lockstep controller makes the robot safe.
const LOCKSTEP_SILENCE: Duration = Duration::from_secs(2);
/// The same in real time: 20 periods.
const REALTIME_SILENCE: Duration = Duration::from_micros(SILENCE_TICKS_MAX as u64 * TICK_US as u64);
/// Patience of a controller that is there for one mission only.
const ONCE_PATIENCE: Duration = Duration::from_secs(30);
/// Period at which a frame is tried again that the bus has no room for, or that finds it down, and how long.
const RETRY: Duration = Duration::from_micros(200);

/// How the shell behaves.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShellOptions {
    /// Ticks come by the clock: silence is 20 periods instead of 2 s.
    pub realtime: bool,
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
    node: Node,
    options: ShellOptions,
    started: Instant,
    /// When the world was last heard.
    heard: Instant,
    announced: Option<Instant>,
    running: bool,
    twin_told: bool,
    longest_tick: Duration,
}

impl<'a> Shell<'a> {
    /// A controller that was just switched on.
    pub fn new(bus: &'a mut dyn LiveBus, options: ShellOptions) -> Self {
        let now = Instant::now();
        Self {
            node: Node::new(bus.mtu()),
            bus,
            options,
            started: now,
            heard: now,
            announced: None,
            running: false,
            twin_told: false,
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
            if self.node.is_free() && self.announced.is_none_or(|at| at.elapsed() >= ANNOUNCE) {
                self.announce();
            }
            let patience = if self.options.realtime && self.running { REALTIME_SILENCE / 4 } else { ANNOUNCE / 4 };
            self.bus.wait(patience);
            if let Some(end) = self.take(tell).or_else(|| self.watch(tell)) {
                return end;
            }
        }
    }

    /// Shows this node's id and listens for another node that bears it. `false` if there is one.
    fn claim(&mut self) -> bool {
        let bus = &mut self.bus;
        self.node.beat(0, &mut |frame| send(*bus, frame));
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

    fn announce(&mut self) {
        self.announced = Some(Instant::now());
        let uptime_s = self.started.elapsed().as_secs() as u32;
        let bus = &mut self.bus;
        self.node.announce(uptime_s, &mut |frame| send(*bus, frame));
    }

    /// Takes what has arrived.
    fn take(&mut self, tell: &mut dyn FnMut(Said)) -> Option<ShellEnd> {
        while let Some(received) = self.bus.receive() {
            let Ok(header) = Header::of(&received.frame) else { continue };
            if header.source == WORLD {
                self.heard = Instant::now();
            }
            let was_free = self.node.is_free();
            let began = Instant::now();
            let bus = &mut self.bus;
            let ticked = self.node.receive(&received.frame, &mut |frame| send(*bus, frame));
            if header.source == CONTROLLER {
                self.meet_twin(tell);
            }
            if !ticked {
                continue;
            }
            if was_free && !self.node.is_free() {
                self.running = true;
                self.longest_tick = Duration::ZERO;
                tell(Said::MissionBegins);
            }
            self.longest_tick = self.longest_tick.max(began.elapsed());
            if let Some(version) = self.node.foreign_version().filter(|_| was_free) {
                tell(Said::Version(version));
                if self.options.once {
                    return Some(ShellEnd::Version(version));
                }
            }
            if self.running && self.node.is_free() {
                self.running = false;
                if let Some(end) = self.tell_end(tell)
                    && self.options.once
                {
                    self.linger();
                    return Some(ShellEnd::MissionOver(end));
                }
            }
        }
        None
    }

    /// Another controller speaks: it shall hear that it is not alone.
    fn meet_twin(&mut self, tell: &mut dyn FnMut(Said)) {
        if !self.twin_told {
            self.twin_told = true;
            tell(Said::Twin);
        }
        if self.announced.is_none_or(|at| at.elapsed() >= CLAIM / 10) {
            self.announce();
        }
    }

    fn tell_end(&self, tell: &mut dyn FnMut(Said)) -> Option<EventKind> {
        let (end, report) = self.node.end()?;
        tell(Said::MissionOver {
            end,
            ticks: report.ticks,
            digest: u64::from_le_bytes(report.digest),
            longest_tick: self.longest_tick,
            stats: self.node.stats(),
        });
        Some(end)
    }

    /// The robot comes to rest under this controller until the world falls silent.
    fn linger(&mut self) {
        while self.heard.elapsed() < REALTIME_SILENCE * 5 {
            self.bus.wait(REALTIME_SILENCE);
            while let Some(received) = self.bus.receive() {
                self.heard = Instant::now();
                let bus = &mut self.bus;
                self.node.receive(&received.frame, &mut |frame| send(*bus, frame));
            }
        }
    }

    /// Looks at the clock.
    fn watch(&mut self, tell: &mut dyn FnMut(Said)) -> Option<ShellEnd> {
        let silent = self.heard.elapsed();
        let limit = if self.options.realtime { REALTIME_SILENCE } else { LOCKSTEP_SILENCE };
        if self.running && silent >= limit {
            self.running = false;
            // As many empty ticks as it takes, and one more for the commands that follow from it.
            for _ in 0..=SILENCE_TICKS_MAX {
                let bus = &mut self.bus;
                self.node.silent_tick(&mut |frame| send(*bus, frame));
            }
            self.node.forget_world();
            tell(Said::Silence(silent));
            self.tell_end(tell);
            return self.options.once.then_some(ShellEnd::Silence);
        }
        let idle = self.options.once && !self.running && silent >= ONCE_PATIENCE;
        idle.then_some(ShellEnd::NoWorld)
    }
}

/// Sends a frame; one that the bus has no room for is tried again for as long as the world would wait for it.
fn send(bus: &mut dyn LiveBus, frame: CanFrame) {
    let until = Instant::now() + REALTIME_SILENCE;
    while bus.send(frame).is_err() && Instant::now() < until {
        std::thread::sleep(RETRY);
    }
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
