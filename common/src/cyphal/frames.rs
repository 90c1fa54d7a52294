//! One transfer, cut into frames.

use super::{CRC_BYTES, CRC_INITIAL, TailByte, crc_extend};
use crate::can::{CanFrame, DATA_BYTES_MAX, Mtu};

/// How a payload is laid out over frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    /// Zero bytes after the payload.
    padding: usize,
    /// Payload, padding and, with several frames, CRC.
    stream_bytes: usize,
}

impl Layout {
    /// Specification, section 4.2.2.3: only the last frame may need padding, so that its length exists in CAN FD.
    const fn of(payload_bytes: usize, mtu: Mtu) -> Self {
        let per_frame = mtu.bytes() - 1;
        let unpadded = if payload_bytes <= per_frame { payload_bytes } else { payload_bytes + CRC_BYTES };
        let full_frames = unpadded / per_frame;
        let last = unpadded - full_frames * per_frame;
        let padding = match mtu.frame_bytes(last + 1) {
            Some(frame) => frame - 1 - last,
            None => 0, // `last` is below `per_frame`: such a frame exists
        };
        // Nothing left over for a last frame: the frame before it is the last, and full.
        let padding = if last == 0 { 0 } else { padding };
        Self { padding, stream_bytes: unpadded + padding }
    }
}

/// Bytes that a receiver gets for a payload of `payload_bytes`: payload and padding, without CRC. Never falls as the
/// payload grows, so a [`super::Session`] of `received_bytes(longest payload, Mtu::Fd)` bytes holds every one.
pub const fn received_bytes(payload_bytes: usize, mtu: Mtu) -> usize {
    payload_bytes + Layout::of(payload_bytes, mtu).padding
}

/// Data bytes of each frame that a payload of `payload_bytes` becomes, in the order of sending.
pub fn frame_lengths(payload_bytes: usize, mtu: Mtu) -> impl Iterator<Item = usize> {
    let per_frame = mtu.bytes() - 1;
    let stream = Layout::of(payload_bytes, mtu).stream_bytes;
    let frames = stream.div_ceil(per_frame).max(1);
    (0..frames).map(move |n| (stream - n * per_frame).min(per_frame) + 1)
}

/// The frames of one transfer, in the order in which they must be sent.
#[derive(Clone, Debug)]
pub struct Frames<'a> {
    id: u32,
    transfer_id: u8,
    mtu: Mtu,
    payload: &'a [u8],
    layout: Layout,
    crc: [u8; CRC_BYTES],
    /// Bytes of the stream already given out.
    position: usize,
    toggle: bool,
    done: bool,
}

impl<'a> Frames<'a> {
    /// Cuts `payload` into frames of format `mtu` with identifier `id` (29 bits; upper bits are ignored).
    pub(super) fn new(id: u32, transfer_id: u8, payload: &'a [u8], mtu: Mtu) -> Self {
        let layout = Layout::of(payload.len(), mtu);
        let mut crc = crc_extend(CRC_INITIAL, payload);
        for _ in 0..layout.padding {
            crc = crc_extend(crc, &[0]);
        }
        let id = id & crate::can::ID_MAX;
        Self { id, transfer_id, mtu, payload, layout, crc: crc.to_be_bytes(), position: 0, toggle: true, done: false }
    }

    /// Byte `at` of payload, padding, CRC.
    fn stream_byte(&self, at: usize) -> u8 {
        let after_padding = at.checked_sub(self.payload.len() + self.layout.padding);
        let crc = after_padding.and_then(|at| self.crc.get(at));
        self.payload.get(at).or(crc).copied().unwrap_or(0)
    }
}

impl Iterator for Frames<'_> {
    type Item = CanFrame;

    fn next(&mut self) -> Option<CanFrame> {
        if self.done {
            return None;
        }
        let left = self.layout.stream_bytes - self.position;
        let count = left.min(self.mtu.bytes() - 1);
        let tail = TailByte {
            start: self.position == 0,
            end: count == left,
            toggle: self.toggle,
            transfer_id: self.transfer_id,
        };
        let mut data = [0; DATA_BYTES_MAX];
        let bytes = data.get_mut(..=count)?;
        for (offset, byte) in bytes.iter_mut().enumerate() {
            *byte = if offset == count { tail.emit() } else { self.stream_byte(self.position + offset) };
        }
        let frame = CanFrame::new(self.id, bytes, self.mtu).ok()?;
        self.position += count;
        self.toggle = !self.toggle;
        self.done = tail.end;
        Some(frame)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.layout.stream_bytes - self.position;
        let frames = if self.done { 0 } else { left.div_ceil(self.mtu.bytes() - 1).max(1) };
        (frames, Some(frames))
    }
}

impl ExactSizeIterator for Frames<'_> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_count_is_known_beforehand_and_all_but_the_last_are_full() {
        let payload = [0x5a; 300];
        for mtu in Mtu::ALL {
            for len in 0..=payload.len() {
                let frames = Frames::new(1, 0, &payload[..len], mtu);
                let expected = frames.len();
                let mut count = 0;
                for frame in frames.clone() {
                    count += 1;
                    assert_eq!(frame.mtu(), mtu);
                    assert!(count == expected || frame.data().len() == mtu.bytes(), "{len} bytes {mtu:?}");
                }
                assert_eq!(count, expected, "{len} bytes {mtu:?}");
                assert!(frames.map(|frame| frame.data().len()).eq(frame_lengths(len, mtu)), "{len} bytes {mtu:?}");
            }
        }
    }

    #[test]
    fn received_bytes_never_fall_as_the_payload_grows() {
        for mtu in Mtu::ALL {
            assert!((0..5000).all(|len| received_bytes(len, mtu) <= received_bytes(len + 1, mtu)));
            assert!((0..5000).all(|len| (len..len + 16).contains(&received_bytes(len, mtu))));
        }
        assert!((0..5000).all(|len| received_bytes(len, Mtu::Classic) == len));
        assert_eq!([41, 63, 64, 94].map(|len| received_bytes(len, Mtu::Fd)), [47, 63, 64, 108]);
    }

    #[test]
    fn an_empty_payload_is_one_frame_with_a_tail_byte() {
        for mtu in Mtu::ALL {
            let mut frames = Frames::new(1, 3, &[], mtu);
            assert_eq!(frames.next().unwrap().data(), &[0xe3]);
            assert_eq!(frames.next(), None);
        }
    }
}
