//! World and controller as processes on `vcan0`, and who listens there.

use crate::candump;
use crate::eavesdropper::Eavesdropper;
use crate::process::Process;
use crate::program::{self, Profile};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use tactus_common::can::CanFrame;
use tactus_common::message::Phase;
use tactus_hil::bus::{Bus, LiveBus};
use tactus_hil::socketcan_bus::SocketCanBus;

/// The interface.
pub const INTERFACE: &str = "vcan0";
/// Its name as a bus.
pub const BUS: &str = "socketcan:vcan0";
/// Long enough for a whole mission on the slowest machine that runs these tests.
pub const MISSION: Duration = Duration::from_secs(120);
/// Long enough for anything that takes no mission.
pub const SOON: Duration = Duration::from_secs(15);
/// A mission of one uncertain component, which is over sooner.
pub const SHORT: [&str; 2] = ["--dof", "1"];

/// The controller's program.
pub fn controller_path() -> PathBuf {
    // `tactus run` expects it there too.
    program::path(Profile::Release).with_file_name("tactus-controller")
}

/// A controller on the bus.
pub fn controller(args: &[&str]) -> Process {
    Process::start(controller_path(), &[&["--bus", BUS], args].concat())
}

/// A controller that is ready for a world.
///
/// # Panics
/// If it is not in time.
pub fn ready_controller(args: &[&str]) -> Process {
    let mut process = controller(args);
    process.wait_for("ready", SOON);
    process
}

/// A world on the bus that serves controllers.
pub fn world(args: &[&str]) -> Process {
    Process::start(program::path(Profile::Release), &[&["serve", "--bus", BUS], args].concat())
}

/// The summary of a mission in one process.
pub fn in_process(args: &[&str]) -> Value {
    let (summary, ran) = program::summary(Profile::Release, &[&["run", "--quiet"], args].concat());
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    summary
}

/// The digest of the [`SHORT`] mission in one process, in hexadecimal digits.
///
/// # Panics
/// If the mission fails.
pub fn short_digest() -> &'static str {
    static DIGEST: OnceLock<String> = OnceLock::new();
    DIGEST.get_or_init(|| in_process(&SHORT)["digest"].as_str().expect("a digest").to_owned())
}

/// The summary of a mission in two processes.
pub fn in_two_processes(args: &[&str]) -> Value {
    let (summary, ran) = program::summary(Profile::Release, &[&["run", "--quiet", "--bus", BUS], args].concat());
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    summary
}

/// Takes the interface down or up.
///
/// # Panics
/// If the system refuses.
pub fn set_link(state: &str) {
    let done = Command::new("ip").args(["link", "set", INTERFACE, state]).status().expect("there is ip");
    assert!(done.success(), "ip link set {INTERFACE} {state}");
}

/// Runs a shell line to its end.
///
/// # Panics
/// If it fails.
pub fn shell(line: &str) {
    let done = Command::new("sh").args(["-c", line]).status().expect("there is a shell");
    assert!(done.success(), "{line}: {done}");
}

/// `candump`, writing all that it sees to a file.
pub struct Witness {
    process: Process,
    log: PathBuf,
}

impl Witness {
    /// Begins to write.
    ///
    /// # Panics
    /// If there is no `candump`.
    pub fn begin(name: &str) -> Self {
        // In memory, where it writes fast, and with a queue of 64 MiB: it shares its processor with both ends.
        let log = PathBuf::from("/dev/shm").join(name);
        let line = format!("exec candump -L -d -r 67108864 {INTERFACE} >'{}'", log.display());
        let process = Process::start("sh", &["-c", &line]);
        // It has no way to say that it listens.
        std::thread::sleep(Duration::from_millis(300));
        Self { process, log }
    }

    /// All frames that it saw.
    ///
    /// # Panics
    /// If it saw that it missed some.
    pub fn end(mut self) -> Vec<CanFrame> {
        std::thread::sleep(Duration::from_millis(300));
        self.process.interrupt(SOON);
        assert_eq!(self.process.lines(), Vec::<String>::new(), "candump misses nothing");
        let log = std::fs::read_to_string(&self.log).expect("candump wrote its log");
        let _ = std::fs::remove_file(&self.log);
        let dropped = log.lines().find(|line| line.contains("DROPCOUNT"));
        assert_eq!(dropped, None, "candump misses nothing");
        candump::frames(&log)
    }
}

/// Listens to a mission as it goes on.
pub struct Ear {
    bus: SocketCanBus,
    listener: Eavesdropper,
}

impl Ear {
    /// Listens from now on.
    ///
    /// # Panics
    /// If there is no such interface.
    pub fn open() -> Self {
        let bus = SocketCanBus::open(INTERFACE, None, &[]).expect("vcan0 is up");
        Self { bus, listener: Eavesdropper::default() }
    }

    /// Waits until the mission is in this phase.
    ///
    /// # Panics
    /// If that is not in time.
    pub fn wait_for_phase(&mut self, phase: Phase, limit: Duration) {
        self.wait_until(limit, |listener| listener.phase() == Some(phase));
    }

    /// Waits until the mission is at this tick, or over.
    ///
    /// # Panics
    /// If that is not in time.
    pub fn wait_for_tick(&mut self, tick: u32, limit: Duration) {
        self.wait_until(limit, |l| l.tick().is_some_and(|now| now >= tick) || l.finished().is_some());
    }

    fn wait_until(&mut self, limit: Duration, reached: impl Fn(&Eavesdropper) -> bool) {
        let started = Instant::now();
        while !reached(&self.listener) {
            let (phase, tick) = (self.listener.phase(), self.listener.tick());
            assert!(started.elapsed() < limit, "not there within {limit:?}, but in phase {phase:?} at tick {tick:?}");
            self.bus.wait(Duration::from_millis(100));
            while !reached(&self.listener)
                && let Some(received) = self.bus.receive()
            {
                self.listener.hear(&received.frame);
            }
        }
    }
}
