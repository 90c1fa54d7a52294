//! Bytes from one writer (an interrupt) to one reader (the loop), without locks.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// A queue of at most `N` bytes; `N` must be a power of two.
#[derive(Debug)]
pub struct ByteRing<const N: usize> {
    slots: [AtomicU8; N],
    /// Bytes written and read since the start, modulo 2^32.
    written: AtomicU32,
    read: AtomicU32,
    lost: AtomicU32,
}

impl<const N: usize> Default for ByteRing<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> ByteRing<N> {
    /// An empty queue.
    pub const fn new() -> Self {
        const { assert!(N.is_power_of_two() && N <= 1 << 16, "the counts wrap at a multiple of the queue's length") };
        Self {
            slots: [const { AtomicU8::new(0) }; N],
            written: AtomicU32::new(0),
            read: AtomicU32::new(0),
            lost: AtomicU32::new(0),
        }
    }

    fn slot(&self, count: u32) -> Option<&AtomicU8> {
        self.slots.get(count as usize % N)
    }

    /// Adds a byte; one too many is dropped and counted. For the one writer.
    pub fn push(&self, byte: u8) {
        let written = self.written.load(Ordering::Relaxed);
        let waiting = written.wrapping_sub(self.read.load(Ordering::Acquire));
        match self.slot(written) {
            Some(slot) if (waiting as usize) < N => {
                slot.store(byte, Ordering::Relaxed);
                self.written.store(written.wrapping_add(1), Ordering::Release);
            }
            _ => self.lost.store(self.lost.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed),
        }
    }

    /// The oldest byte. For the one reader.
    pub fn pop(&self) -> Option<u8> {
        let read = self.read.load(Ordering::Relaxed);
        if read == self.written.load(Ordering::Acquire) {
            return None;
        }
        let byte = self.slot(read)?.load(Ordering::Relaxed);
        self.read.store(read.wrapping_add(1), Ordering::Release);
        Some(byte)
    }

    /// Is there nothing to read?
    pub fn is_empty(&self) -> bool {
        self.read.load(Ordering::Relaxed) == self.written.load(Ordering::Acquire)
    }

    /// Bytes for which there was no room.
    pub fn lost(&self) -> u32 {
        self.lost.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;

    #[test]
    fn bytes_come_out_as_they_went_in_also_across_threads() {
        static RING: ByteRing<8> = ByteRing::new();
        let writer = std::thread::spawn(|| {
            for n in 0..10_000_u32 {
                // A full queue would drop: the writer of this test waits instead.
                while RING.written.load(Ordering::Relaxed).wrapping_sub(RING.read.load(Ordering::Relaxed)) == 8 {
                    std::thread::yield_now();
                }
                RING.push(n as u8);
            }
        });
        for n in 0..10_000_u32 {
            let byte = loop {
                match RING.pop() {
                    Some(byte) => break byte,
                    None => std::thread::yield_now(),
                }
            };
            assert_eq!(byte, n as u8);
        }
        writer.join().unwrap();
        assert_eq!(RING.lost(), 0);
    }

    #[test]
    fn a_full_queue_drops_the_newest_and_counts_them() {
        let ring = ByteRing::<4>::new();
        (1..=6).for_each(|byte| ring.push(byte));
        assert_eq!(ring.lost(), 2);
        assert!([1, 2, 3, 4].into_iter().eq(core::iter::from_fn(|| ring.pop())));
        assert!(ring.is_empty());
    }

    #[test]
    fn the_counts_may_wrap() {
        let ring = ByteRing::<4>::new();
        ring.written.store(u32::MAX - 1, Ordering::Relaxed);
        ring.read.store(u32::MAX - 1, Ordering::Relaxed);
        (1..=5).for_each(|byte| ring.push(byte));
        assert!([1, 2, 3, 4].into_iter().eq(core::iter::from_fn(|| ring.pop())));
        assert_eq!(ring.lost(), 1);
    }
}
