//! Why frames were not accepted, and how often.

/// Error returned by [`super::Session::accept`]: this frame brought nothing, and why. All are expected on a real bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RxError {
    /// No data, so no tail byte.
    Empty,
    /// The tail byte or the length contradicts the protocol: a first frame without toggle bit (UAVCAN v0), frames of
    /// unequal length within a transfer, a multi-frame transfer with frames that are not full.
    Malformed,
    /// Part of a transfer whose beginning did not arrive.
    NoStart,
    /// A frame of the transfer is missing or came out of turn; the transfer is given up.
    FrameLost,
    /// The transfer took longer than the timeout; it is given up.
    Timeout,
    /// This transfer, or a part of it, was received before.
    Duplicate,
    /// An older transfer than the one delivered last.
    Stale,
    /// The transfer is longer than the session's buffer; it is given up.
    Oversize,
    /// The transfer's CRC does not fit its content.
    Crc,
}

impl core::fmt::Display for RxError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Empty => "frame without data",
            Self::Malformed => "tail byte or length contradicts Cyphal/CAN",
            Self::NoStart => "the transfer's beginning did not arrive",
            Self::FrameLost => "a frame of the transfer is missing",
            Self::Timeout => "the transfer took too long",
            Self::Duplicate => "received before",
            Self::Stale => "older than the transfer delivered last",
            Self::Oversize => "transfer exceeds the session's buffer",
            Self::Crc => "transfer CRC mismatch",
        })
    }
}

impl core::error::Error for RxError {}

/// What became of the frames that a session was given. Counters stop at their maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RxStats {
    /// Frames of this session's subject and source.
    pub frames: u32,
    /// Transfers delivered.
    pub transfers: u32,
    /// Transfers that began and were given up: a lost frame, timeout, oversize, CRC, or the next one began.
    pub given_up: u32,
    /// Transfer-IDs skipped between delivered transfers: at least so many never arrived whole (unless the source
    /// restarted in between, which starts its count over).
    pub missed: u32,
    /// [`RxError::Empty`] and [`RxError::Malformed`].
    pub malformed: u32,
    /// [`RxError::NoStart`].
    pub no_start: u32,
    /// [`RxError::FrameLost`].
    pub frame_lost: u32,
    /// [`RxError::Timeout`].
    pub timeout: u32,
    /// [`RxError::Duplicate`].
    pub duplicate: u32,
    /// [`RxError::Stale`].
    pub stale: u32,
    /// [`RxError::Oversize`].
    pub oversize: u32,
    /// [`RxError::Crc`].
    pub crc: u32,
}

/// One more, but never past the end.
pub(super) fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl RxStats {
    /// Nothing received.
    pub const ZERO: Self = Self {
        frames: 0,
        transfers: 0,
        given_up: 0,
        missed: 0,
        malformed: 0,
        no_start: 0,
        frame_lost: 0,
        timeout: 0,
        duplicate: 0,
        stale: 0,
        oversize: 0,
        crc: 0,
    };

    /// Counts an error.
    pub(super) fn record(&mut self, error: RxError) {
        count(match error {
            RxError::Empty | RxError::Malformed => &mut self.malformed,
            RxError::NoStart => &mut self.no_start,
            RxError::FrameLost => &mut self.frame_lost,
            RxError::Timeout => &mut self.timeout,
            RxError::Duplicate => &mut self.duplicate,
            RxError::Stale => &mut self.stale,
            RxError::Oversize => &mut self.oversize,
            RxError::Crc => &mut self.crc,
        });
    }

    /// Frames that brought an error.
    pub fn errors(&self) -> u32 {
        [
            self.malformed,
            self.no_start,
            self.frame_lost,
            self.timeout,
            self.duplicate,
            self.stale,
            self.oversize,
            self.crc,
        ]
        .into_iter()
        .fold(0, u32::saturating_add)
    }
}
