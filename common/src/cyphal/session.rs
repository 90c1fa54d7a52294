//! Puts the transfers of one subject from one source together again.

use super::stats::count;
use super::{
    CRC_BYTES, CRC_INITIAL, Header, NodeId, Priority, RxError, RxStats, SubjectId, TRANSFER_ID_MODULO, TailByte,
    crc_extend,
};
use crate::can::Mtu;

/// A transfer that arrived whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer<'a> {
    /// The priority that it was sent with.
    pub priority: Priority,
    /// Its number, 0..31.
    pub transfer_id: u8,
    /// When its first frame was accepted, in the caller's unit.
    pub started_at: u64,
    /// The payload. On CAN FD up to 15 zero bytes may follow what was sent: decoders must ignore a tail.
    pub payload: &'a [u8],
}

/// The transfer that was delivered last.
#[derive(Clone, Copy, Debug)]
struct Delivered {
    transfer_id: u8,
    started_at: u64,
}

/// A multi-frame transfer that has begun.
#[derive(Clone, Copy, Debug)]
struct Assembly {
    transfer_id: u8,
    started_at: u64,
    /// Toggle bit of the frame to come.
    toggle: bool,
    /// Payload, padding and CRC bytes of one full frame.
    chunk: usize,
    /// Bytes received so far, CRC included; at most the buffer and a CRC.
    received: usize,
    /// Transfer CRC over them.
    crc: u16,
}

/// Reassembly of one subject from one source, with a buffer of `BYTES` for transfers of several frames.
///
/// `BYTES` should be [`super::received_bytes`] of the longest payload: longer transfers are refused, not cut.
/// Time is the caller's: any unit that does not run backwards, the same for `timeout` and `now`.
///
/// Transfer-IDs decide what is new: within `timeout` of the last delivered transfer, only the next 16 numbers count as
/// newer, the rest as repeated or stale; after it, any number does (the source may have restarted). The timeout should
/// therefore be below 16 periods of a periodic subject, so that a gap cannot make fresh transfers look old.
#[derive(Clone, Debug)]
pub struct Session<const BYTES: usize> {
    subject: SubjectId,
    source: NodeId,
    timeout: u64,
    delivered: Option<Delivered>,
    assembly: Option<Assembly>,
    buffer: [u8; BYTES],
    stats: RxStats,
}

impl<const BYTES: usize> Session<BYTES> {
    /// A session that takes `subject` from `source`.
    pub const fn new(subject: SubjectId, source: NodeId, timeout: u64) -> Self {
        Self { subject, source, timeout, delivered: None, assembly: None, buffer: [0; BYTES], stats: RxStats::ZERO }
    }

    /// As if nothing had ever been received. In place: a new session would pass its buffer over the stack.
    pub fn forget(&mut self) {
        (self.delivered, self.assembly, self.stats) = (None, None, RxStats::ZERO);
    }

    /// The next transfer is new, whatever its number.
    pub fn forget_last(&mut self) {
        self.delivered = None;
    }

    /// Is a frame with this header for this session?
    pub fn wants(&self, header: &Header) -> bool {
        header.subject == self.subject && header.source == self.source
    }

    /// What became of the frames so far.
    pub const fn stats(&self) -> &RxStats {
        &self.stats
    }

    /// Takes one frame: its header, its data (any bytes), and the time.
    ///
    /// `Ok(Some(..))`: the frame completed a transfer. `Ok(None)`: it did not yet, or it is not for this session.
    /// A transfer is delivered once, whole, checked, and never after a newer one; its payload borrows from the frame
    /// or from the session.
    ///
    /// # Errors
    /// [`RxError`] if the frame cannot be used; it is counted, and the session goes on with the next.
    pub fn accept<'a>(
        &'a mut self,
        header: &Header,
        data: &'a [u8],
        now: u64,
    ) -> Result<Option<Transfer<'a>>, RxError> {
        if !self.wants(header) {
            return Ok(None);
        }
        count(&mut self.stats.frames);
        match self.take(data, now) {
            Ok(None) => Ok(None),
            Ok(Some(whole)) => {
                self.deliver(whole);
                let Delivered { transfer_id, started_at } = whole.delivered;
                let payload = match whole.buffered {
                    Some(len) => self.buffer.get(..len),
                    None => data.split_last().map(|(_, payload)| payload),
                };
                let payload = payload.unwrap_or(&[]);
                Ok(Some(Transfer { priority: header.priority, transfer_id, started_at, payload }))
            }
            Err(error) => {
                self.stats.record(error);
                Err(error)
            }
        }
    }

    /// The frame's part in its transfer; `Some` if that is whole now.
    fn take(&mut self, data: &[u8], now: u64) -> Result<Option<Whole>, RxError> {
        let Some((&tail, content)) = data.split_last() else { return Err(RxError::Empty) };
        let tail = TailByte::parse(tail);
        if tail.start {
            if !tail.toggle {
                return Err(RxError::Malformed);
            }
            self.check_newer(tail.transfer_id, now)?;
            self.start(tail, content, now)
        } else {
            self.proceed(tail, content, now)
        }
    }

    /// A first frame: whatever was under way is given up.
    fn start(&mut self, tail: TailByte, content: &[u8], now: u64) -> Result<Option<Whole>, RxError> {
        let begun = Delivered { transfer_id: tail.transfer_id, started_at: now };
        if tail.end {
            self.give_up();
            if content.len() > BYTES {
                return Err(RxError::Oversize);
            }
            return Ok(Some(Whole { delivered: begun, buffered: None }));
        }
        if content.len() + 1 < Mtu::Classic.bytes() {
            // More frames follow, so this one must be full; no format has full frames this short.
            return Err(RxError::Malformed);
        }
        // The same first frame once more (its sender missed our acknowledgement) begins the same transfer again.
        let again = self.assembly.is_some_and(|old| old.transfer_id == tail.transfer_id && old.received == old.chunk);
        if !again {
            self.give_up();
        }
        self.assembly = Some(Assembly {
            transfer_id: tail.transfer_id,
            started_at: now,
            toggle: true,
            chunk: content.len(),
            received: 0,
            crc: CRC_INITIAL,
        });
        self.append(content)?;
        Ok(None)
    }

    /// A frame after the first.
    fn proceed(&mut self, tail: TailByte, content: &[u8], now: u64) -> Result<Option<Whole>, RxError> {
        let Some(assembly) = self.assembly else {
            let repeated = self.delivered.is_some_and(|last| last.transfer_id == tail.transfer_id);
            return Err(if repeated && self.within_timeout(now) { RxError::Duplicate } else { RxError::NoStart });
        };
        if now.saturating_sub(assembly.started_at) > self.timeout {
            self.give_up();
            return Err(RxError::Timeout);
        }
        if tail.transfer_id != assembly.transfer_id {
            // A late part of another transfer; the one under way is none the worse.
            return Err(RxError::NoStart);
        }
        if tail.toggle != assembly.toggle {
            if self.is_last_chunk(&assembly, content) {
                return Err(RxError::Duplicate);
            }
            self.give_up();
            return Err(RxError::FrameLost);
        }
        let full = content.len() == assembly.chunk;
        let fits = if tail.end { !content.is_empty() && content.len() <= assembly.chunk } else { full };
        if !fits {
            self.give_up();
            return Err(RxError::Malformed);
        }
        self.append(content)?;
        if tail.end { self.finish().map(Some) } else { Ok(None) }
    }

    /// Adds a chunk to the transfer under way, which must fit the buffer but for its CRC.
    fn append(&mut self, content: &[u8]) -> Result<(), RxError> {
        let Some(assembly) = self.assembly.as_mut() else { return Err(RxError::NoStart) };
        if assembly.received + content.len() > BYTES + CRC_BYTES {
            self.give_up();
            return Err(RxError::Oversize);
        }
        for (to, from) in self.buffer.iter_mut().skip(assembly.received).zip(content) {
            *to = *from;
        }
        assembly.received += content.len();
        assembly.crc = crc_extend(assembly.crc, content);
        assembly.toggle = !assembly.toggle;
        Ok(())
    }

    /// All frames are there: check the CRC.
    fn finish(&mut self) -> Result<Whole, RxError> {
        let Some(assembly) = self.assembly else { return Err(RxError::NoStart) };
        // The CRC over content and CRC is zero. A first frame has at least 7 bytes, so there is a CRC to take off.
        let payload_bytes = assembly.received.saturating_sub(CRC_BYTES);
        if assembly.crc != 0 {
            self.give_up();
            return Err(RxError::Crc);
        }
        self.assembly = None;
        let delivered = Delivered { transfer_id: assembly.transfer_id, started_at: assembly.started_at };
        Ok(Whole { delivered, buffered: Some(payload_bytes) })
    }

    /// Is `content` what the frame before brought?
    fn is_last_chunk(&self, assembly: &Assembly, content: &[u8]) -> bool {
        let from = assembly.received.saturating_sub(assembly.chunk);
        content.len() == assembly.chunk && self.buffer.iter().skip(from).zip(content).all(|(old, new)| old == new)
    }

    /// Forgets the transfer under way.
    fn give_up(&mut self) {
        if self.assembly.take().is_some() {
            count(&mut self.stats.given_up);
        }
    }

    fn within_timeout(&self, now: u64) -> bool {
        self.delivered.is_some_and(|last| now.saturating_sub(last.started_at) <= self.timeout)
    }

    /// May a transfer with this number begin now?
    fn check_newer(&self, transfer_id: u8, now: u64) -> Result<(), RxError> {
        match self.delivered {
            Some(last) if self.within_timeout(now) => match steps(last.transfer_id, transfer_id) {
                0 => Err(RxError::Duplicate),
                1..=16 => Ok(()),
                _ => Err(RxError::Stale),
            },
            _ => Ok(()),
        }
    }

    /// Books a delivered transfer.
    fn deliver(&mut self, whole: Whole) {
        count(&mut self.stats.transfers);
        if let Some(last) = self.delivered {
            let skipped = steps(last.transfer_id, whole.delivered.transfer_id).saturating_sub(1);
            self.stats.missed = self.stats.missed.saturating_add(u32::from(skipped));
        }
        self.delivered = Some(whole.delivered);
    }
}

/// A transfer that is complete: its number and time, and where its payload lies: so many bytes of the buffer, or
/// (`None`) in the frame itself.
#[derive(Clone, Copy, Debug)]
struct Whole {
    delivered: Delivered,
    buffered: Option<usize>,
}

/// How often `from` must be counted up to become `to`, modulo 32.
const fn steps(from: u8, to: u8) -> u8 {
    (to + TRANSFER_ID_MODULO - from) % TRANSFER_ID_MODULO
}
