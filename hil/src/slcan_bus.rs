//! SLCAN: CAN frames as text over a serial port, a pseudo terminal or a Unix socket (an emulator's serial line).
//!
//! This is the host's side: it opens the adapter's channel as `slcand` does and then sends and takes frames. CAN 2.0
//! only. Nothing here waits but [`SlcanBus::wait`]; what the line does not take at once is kept, up to a limit.

use crate::bus::{Bus, LiveBus, LiveStats, Received, Refusal, Rejected, SendOnly};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FileType, Mode, OFlags, fcntl_setfl, open, stat};
use rustix::io::Errno;
use rustix::termios::{OptionalActions, isatty, tcgetattr, tcsetattr};
use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::slcan::{self, Line, Parser};

/// Speed of a serial port, bits a second: a CAN bus of 1 Mbit/s in hexadecimal would need more, lockstep runs wait.
pub const BAUD: u32 = 1_000_000;
/// Bytes that may wait to be sent: the longest transfer (a trajectory, 630 lines of 27 bytes) three times over.
const WAITING_BYTES_MAX: usize = 51_200;
/// A trajectory of 17 kB takes 0.15 s at 1 Mbit/s, 1.5 s at 115,200 bit/s, and more on an emulated line, whose bytes take
/// tens of microseconds each on a busy machine.
const SLOWNESS: u32 = 10;
/// A line that is down is tried again this often.
const RETRY: Duration = Duration::from_millis(100);

/// One end of a serial line that carries frames.
#[derive(Debug)]
pub struct SlcanBus {
    path: PathBuf,
    line: Arc<Mutex<SharedLine>>,
    parser: Parser,
    arrived: VecDeque<Received>,
    opened: Instant,
    stats: LiveStats,
}

/// What both halves write to. Whole lines are added under one lock, so that those of two threads never mix.
#[derive(Debug)]
struct SharedLine {
    /// `None` while the line is down.
    port: Option<OwnedFd>,
    waiting: VecDeque<u8>,
    sent: u64,
    downs: u64,
}

/// Opens a device, a pseudo terminal or a socket, for reads and writes that do not wait.
fn open_port(path: &Path) -> io::Result<OwnedFd> {
    let told = |error: Errno| io::Error::new(io::Error::from(error).kind(), format!("{}: {error}", path.display()));
    if FileType::from_raw_mode(stat(path).map_err(told)?.st_mode) == FileType::Socket {
        let port = OwnedFd::from(UnixStream::connect(path).map_err(|e| {
            io::Error::new(e.kind(), format!("{}: nobody listens at this socket: {e}", path.display()))
        })?);
        fcntl_setfl(&port, OFlags::NONBLOCK).map_err(told)?;
        return Ok(port);
    }
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let port = open(path, flags, Mode::empty()).map_err(told)?;
    if !isatty(&port) {
        let what = format!("{}: expected a serial port, a pseudo terminal or a socket", path.display());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    let mut settings = tcgetattr(&port).map_err(told)?;
    settings.make_raw();
    settings.set_speed(BAUD).map_err(told)?;
    tcsetattr(&port, OptionalActions::Now, &settings).map_err(told)?;
    Ok(port)
}

impl SharedLine {
    /// Takes the bytes of the commands that open the channel, and is up.
    fn begin(&mut self, port: OwnedFd) {
        self.port = Some(port);
        self.waiting.clear();
        for command in slcan::Command::BEGIN {
            self.waiting.extend(command.encode());
        }
        self.flush();
    }

    /// The line has gone.
    fn drop_port(&mut self) {
        if self.port.take().is_some() {
            self.downs += 1;
            self.waiting.clear();
        }
    }

    /// Writes what the line takes now.
    fn flush(&mut self) {
        while let (Some(port), false) = (&self.port, self.waiting.is_empty()) {
            match rustix::io::write(port, self.waiting.as_slices().0) {
                Ok(taken) => drop(self.waiting.drain(..taken)),
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => return,
                Err(_) => self.drop_port(),
            }
        }
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        let rejected = |reason| Rejected { frame, reason };
        let text = slcan::encode(&frame).map_err(|_| rejected(Refusal::Format))?;
        if self.port.is_none() {
            return Err(rejected(Refusal::Down));
        }
        if self.waiting.len() + text.len() > WAITING_BYTES_MAX {
            self.flush();
            if self.waiting.len() + text.len() > WAITING_BYTES_MAX {
                return Err(rejected(Refusal::Full));
            }
        }
        self.waiting.extend(text);
        self.flush();
        if self.port.is_none() {
            return Err(rejected(Refusal::Down));
        }
        self.sent += 1;
        Ok(())
    }
}

impl SlcanBus {
    /// Opens the line at `path` and, on it, the adapter's channel at 1 Mbit/s.
    ///
    /// # Errors
    /// There is no such device or socket, it may not be used, or it is no serial line; the error names the path.
    pub fn open(path: &Path) -> io::Result<Self> {
        let mut line = SharedLine { port: None, waiting: VecDeque::new(), sent: 0, downs: 0 };
        line.begin(open_port(path)?);
        Ok(Self {
            path: path.to_owned(),
            line: Arc::new(Mutex::new(line)),
            parser: Parser::new(),
            arrived: VecDeque::new(),
            opened: Instant::now(),
            stats: LiveStats::default(),
        })
    }

    fn line(&self) -> MutexGuard<'_, SharedLine> {
        locked(&self.line)
    }

    /// Takes what has arrived on the line.
    fn read(&mut self) {
        let mut bytes = [0; 4_096];
        let mut line = locked(&self.line);
        let Some(port) = &line.port else { return };
        let count = match rustix::io::read(port, &mut bytes) {
            Ok(0) => return line.drop_port(),
            Ok(count) => count,
            Err(Errno::AGAIN | Errno::INTR) => return,
            Err(_) => return line.drop_port(),
        };
        drop(line);
        for said in bytes.iter().take(count).filter_map(|&byte| self.parser.feed(byte)) {
            match said {
                Line::Frame(frame) => {
                    let at_ns = u64::try_from(self.opened.elapsed().as_nanos()).unwrap_or(u64::MAX);
                    self.arrived.push_back(Received { frame, at_ns });
                }
                Line::Done | Line::Command(_) => {}
                Line::Refused => self.stats.errors += 1,
                Line::Other | Line::Damaged => self.stats.foreign += 1,
            }
        }
    }

    /// Sleeps until the line has something to give or to take, or is back.
    fn sleep(&mut self, timeout: Duration) {
        let mut line = locked(&self.line);
        let Some(port) = &line.port else {
            drop(line);
            std::thread::sleep(timeout.min(RETRY));
            if let Ok(port) = open_port(&self.path) {
                self.parser = Parser::new();
                self.line().begin(port);
            }
            return;
        };
        let Ok(port) = port.as_fd().try_clone_to_owned() else { return };
        line.flush();
        let wanted = if line.waiting.is_empty() { PollFlags::IN } else { PollFlags::IN | PollFlags::OUT };
        drop(line);
        let timeout = Timespec::try_from(timeout).unwrap_or(Timespec { tv_sec: 1, tv_nsec: 0 });
        // Interrupted or not: the caller looks for itself, and asks again while its time is not over.
        let _ = poll(&mut [PollFd::new(&port, wanted)], Some(&timeout));
        self.line().flush();
    }
}

/// A thread that panicked while it held the lock left whole bytes behind, at worst half a line.
fn locked(line: &Mutex<SharedLine>) -> MutexGuard<'_, SharedLine> {
    line.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Bus for SlcanBus {
    fn mtu(&self) -> Mtu {
        Mtu::Classic
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        self.line().send(frame)
    }

    fn receive(&mut self) -> Option<Received> {
        if self.arrived.is_empty() {
            self.line().flush();
            self.read();
        }
        let received = self.arrived.pop_front()?;
        self.stats.received += 1;
        Some(received)
    }
}

impl LiveBus for SlcanBus {
    fn wait(&mut self, timeout: Duration) -> bool {
        let begun = Instant::now();
        loop {
            if self.arrived.is_empty() {
                self.read();
            }
            let left = timeout.saturating_sub(begun.elapsed());
            if !self.arrived.is_empty() || left.is_zero() {
                return !self.arrived.is_empty();
            }
            self.sleep(left);
        }
    }

    fn sender(&self) -> io::Result<Box<dyn SendOnly>> {
        Ok(Box::new(SlcanSender(Arc::clone(&self.line))))
    }

    fn stats(&self) -> LiveStats {
        let line = self.line();
        LiveStats { sent: line.sent, downs: line.downs, ..self.stats }
    }

    fn slowness(&self) -> u32 {
        SLOWNESS
    }
}

/// The sending half, for another thread.
#[derive(Debug)]
struct SlcanSender(Arc<Mutex<SharedLine>>);

impl SendOnly for SlcanSender {
    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        locked(&self.0).send(frame)
    }
}

#[cfg(test)]
mod tests;
