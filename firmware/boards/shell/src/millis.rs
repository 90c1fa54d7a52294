//! Milliseconds from an interrupt to the loop.

use core::sync::atomic::{AtomicU32, Ordering};

/// Milliseconds since the start, modulo 2^32: counted by one interrupt handler, read by everybody.
#[derive(Debug, Default)]
pub struct Millis(AtomicU32);

impl Millis {
    /// None yet.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// One more. For one interrupt handler alone: this is no read-modify-write.
    pub fn count(&self) {
        self.0.store(self.now().wrapping_add(1), Ordering::Relaxed);
    }

    /// How many.
    pub fn now(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn milliseconds_are_counted_and_wrap() {
        let millis = Millis(AtomicU32::new(u32::MAX - 1));
        (0..3).for_each(|_| millis.count());
        assert_eq!(millis.now(), 1);
    }
}
