//! Linux's own CAN interfaces as a bus: `can0`, `vcan0`, a USB adapter.
//!
//! Frames of other nodes that pass the filters arrive with the kernel's time of arrival; frames of this socket do not
//! come back. The interface may go down and up again, or away and come back under its name: the bus is then down in
//! between, and goes on by itself.

mod convert;
mod error;
mod filter;

pub use error::OpenError;
pub use filter::IdFilter;

use crate::bus::{Bus, LiveBus, LiveStats, Received, Refusal, Rejected, SendOnly};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use socketcan::nl::Mtu as InterfaceMtu;
use socketcan::{CanAddr, CanFdSocket, CanInterface, ShouldRetry, Socket, SocketOptions};
use std::io;
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tactus_common::can::{CanFrame, Mtu};

/// Bytes of received frames that the kernel keeps for us, if it lets us: 4 MiB, about 4000 frames, 2 s of a wire that is
/// always busy with long ones. (The kernel charges 0.8 KiB and more for a frame.)
const RECEIVE_QUEUE_BYTES: i32 = 4 << 20;

/// An interface that is away is looked for this often.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// Frames looked at in one go for one of ours; so a flood of others does not keep [`Bus::receive`] from returning.
const FRAMES_AT_ONCE: u32 = 64;

/// Where the count of dropped frames is in what `SO_MEMINFO` tells, and its number (`linux/sock_diag.h`,
/// `asm-generic/socket.h`).
const MEMINFO_DROPS: usize = libc::SK_MEMINFO_DROPS as usize;
const SO_MEMINFO: i32 = 55;

/// What is known of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Link {
    /// It carries frames, as far as we know.
    Up,
    /// It is down; the socket hears when it is up again.
    Down,
    /// It is away. The socket must be bound to the next of this name, if there is one.
    Away,
}

/// A node's access to an interface.
#[derive(Debug)]
pub struct SocketCanBus {
    socket: CanFdSocket,
    interface: String,
    format: Mtu,
    filters: Vec<IdFilter>,
    fetched: Option<Received>,
    link: Link,
    looked_at: Instant,
    stats: LiveStats,
    /// Frames sent, also by [`Sender`]s.
    sent: Arc<AtomicU64>,
}

impl SocketCanBus {
    /// Opens the interface, which must be up. Sends frames of `format`; without one, of the largest that the interface
    /// takes. Receives frames that pass one of the filters; without filters, all.
    ///
    /// # Errors
    /// [`OpenError`], which says what is wrong and what was expected.
    pub fn open(interface: &str, format: Option<Mtu>, filters: &[IdFilter]) -> Result<Self, OpenError> {
        let refuse = |error| OpenError::System { interface: interface.to_owned(), error };
        error::kernel_has_can()?;
        let address =
            CanAddr::from_iface(interface).map_err(|_| OpenError::NoInterface { interface: interface.to_owned() })?;
        let socket = CanFdSocket::open_addr(&address).map_err(|error| match error.raw_os_error() {
            Some(libc::ENODEV) => OpenError::NotCan { interface: interface.to_owned() },
            _ => refuse(error),
        })?;
        let details = CanInterface::open(interface)
            .and_then(|i| i.details())
            .map_err(|error| refuse(io::Error::other(error.to_string())))?;
        if !details.is_up {
            return Err(OpenError::Down { interface: interface.to_owned() });
        }
        let carries = if details.mtu == Some(InterfaceMtu::Standard) { Mtu::Classic } else { Mtu::Fd };
        let format = format.unwrap_or(carries);
        if format.bytes() > carries.bytes() {
            return Err(OpenError::Format { interface: interface.to_owned() });
        }
        let mut bus = Self {
            socket,
            interface: interface.to_owned(),
            format,
            filters: filters.to_vec(),
            fetched: None,
            link: Link::Up,
            looked_at: Instant::now(),
            stats: LiveStats::default(),
            sent: Arc::default(),
        };
        bus.set_up().map_err(refuse)?;
        // What came before the filters were set may be anything.
        while bus.read().is_ok() {}
        bus.stats = LiveStats::default();
        Ok(bus)
    }

    /// The interface's name.
    pub fn interface(&self) -> &str {
        &self.interface
    }

    /// All that the socket is told once.
    fn set_up(&self) -> io::Result<()> {
        self.socket.set_nonblocking(true)?;
        self.socket.set_recv_timestamp(true)?;
        self.socket.set_error_filter_accept_all()?;
        let set = |option| self.socket.set_socket_option_int(libc::SOL_SOCKET, option, RECEIVE_QUEUE_BYTES);
        // Beyond the system's limit if we may, else as much as there is.
        set(libc::SO_RCVBUFFORCE).or_else(|_| set(libc::SO_RCVBUF))?;
        self.set_filters()
    }

    fn set_filters(&self) -> io::Result<()> {
        if self.filters.is_empty() {
            self.socket.set_filter_accept_all()
        } else {
            self.socket.set_filters(&self.filters)
        }
    }

    /// One frame from the socket, if it is one for us; `Ok(None)` if it was something else, which is counted.
    fn read(&mut self) -> io::Result<Option<Received>> {
        match self.socket.read_frame_with_timestamps() {
            Ok((socketcan::CanAnyFrame::Error(_), _)) => {
                self.stats.errors += 1;
                Ok(None)
            }
            Ok((frame, times)) => {
                self.link = Link::Up;
                let Some(frame) = convert::from_socketcan(&frame) else {
                    self.stats.foreign += 1;
                    return Ok(None);
                };
                self.stats.received += 1;
                Ok(Some(Received { frame, at_ns: nanoseconds(times.socket.unwrap_or_else(SystemTime::now)) }))
            }
            // A length that no frame has.
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                self.stats.foreign += 1;
                Ok(None)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(None),
            Err(error) => {
                if !error.should_retry() {
                    self.find_down(&error);
                }
                Err(error)
            }
        }
    }

    /// Fetches the next frame for us, if it has come.
    fn fetch(&mut self) -> bool {
        for _ in 0..FRAMES_AT_ONCE {
            if self.fetched.is_some() {
                return true;
            }
            match self.read() {
                Ok(got) => self.fetched = got,
                Err(_) => break,
            }
        }
        self.fetched.is_some()
    }

    /// The system says that the interface does not work.
    fn find_down(&mut self, error: &io::Error) {
        let link = if gone(error) { Link::Away } else { Link::Down };
        if self.link == Link::Up {
            self.stats.downs += 1;
        }
        if self.link != Link::Away {
            self.link = link;
        }
    }

    /// Looks for the interface if it is away, not too often.
    fn look_again(&mut self) {
        if self.link != Link::Away || self.looked_at.elapsed() < LOOK_AGAIN {
            return;
        }
        self.looked_at = Instant::now();
        let Ok(address) = CanAddr::from_iface(&self.interface) else { return };
        // The kernel forgets the filters of an interface that has gone.
        if self.socket.as_raw_socket().bind(&address.into_sock_addr()).and_then(|()| self.set_filters()).is_ok() {
            self.link = Link::Down;
        }
    }
}

impl Bus for SocketCanBus {
    fn mtu(&self) -> Mtu {
        self.format
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        self.look_again();
        let sent = send(&self.socket, self.format, &frame);
        match sent {
            Ok(()) => {
                self.link = Link::Up;
                self.sent.fetch_add(1, Ordering::Relaxed);
                Ok(())
            }
            Err((reason, error)) => {
                if let (Refusal::Down, Some(error)) = (reason, error) {
                    self.find_down(&error);
                }
                Err(Rejected { frame, reason })
            }
        }
    }

    fn receive(&mut self) -> Option<Received> {
        self.fetch();
        self.fetched.take()
    }
}

impl LiveBus for SocketCanBus {
    fn wait(&mut self, timeout: Duration) -> bool {
        let started = Instant::now();
        loop {
            self.look_again();
            if self.fetch() {
                return true;
            }
            let left = timeout.saturating_sub(started.elapsed());
            if left.is_zero() {
                return false;
            }
            if self.link == Link::Away {
                std::thread::sleep(left.min(LOOK_AGAIN));
                continue;
            }
            let mut ready = [PollFd::new(&self.socket, PollFlags::IN)];
            let time = Timespec { tv_sec: left.as_secs() as i64, tv_nsec: i64::from(left.subsec_nanos()) };
            if poll(&mut ready, Some(&time)).is_err_and(|error| error != rustix::io::Errno::INTR) {
                std::thread::sleep(left.min(LOOK_AGAIN));
            }
        }
    }

    fn sender(&self) -> io::Result<Box<dyn SendOnly>> {
        let socket = CanFdSocket::from(self.socket.as_fd().try_clone_to_owned()?);
        Ok(Box::new(Sender { socket, format: self.format, sent: Arc::clone(&self.sent) }))
    }

    fn stats(&self) -> LiveStats {
        let mut words = [0; 4 * (MEMINFO_DROPS + 1)];
        let told = self.socket.get_socket_option_bytes(libc::SOL_SOCKET, SO_MEMINFO, &mut words);
        let lost = match (told, words.last_chunk()) {
            (Ok(bytes), Some(drops)) if bytes == words.len() => u32::from_ne_bytes(*drops),
            _ => 0,
        };
        LiveStats { sent: self.sent.load(Ordering::Relaxed), lost: u64::from(lost), ..self.stats }
    }
}

/// The sending half.
struct Sender {
    socket: CanFdSocket,
    format: Mtu,
    sent: Arc<AtomicU64>,
}

impl SendOnly for Sender {
    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        send(&self.socket, self.format, &frame).map_err(|(reason, _)| Rejected { frame, reason })?;
        self.sent.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }
}

/// Sends one frame, or says why not, and what the system said.
fn send(socket: &CanFdSocket, format: Mtu, frame: &CanFrame) -> Result<(), (Refusal, Option<io::Error>)> {
    if frame.is_fd() && format == Mtu::Classic {
        return Err((Refusal::Format, None));
    }
    let converted = convert::to_socketcan(frame).ok_or((Refusal::Format, None))?;
    socket.write_frame(&converted).map_err(|error| {
        let reason = match error.raw_os_error() {
            // The socket's share of the interface's queue, or the queue itself.
            Some(libc::EAGAIN | libc::ENOBUFS) => Refusal::Full,
            Some(libc::EINVAL | libc::EMSGSIZE) => Refusal::Format,
            _ => Refusal::Down,
        };
        (reason, Some(error))
    })
}

/// Does this error say that the socket is no longer bound to an interface?
fn gone(error: &io::Error) -> bool {
    matches!(error.raw_os_error(), Some(libc::ENODEV | libc::ENXIO))
}

/// Since 1970, as the kernel stamps frames.
fn nanoseconds(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(u64::MAX))
}
