//! Time: SysTick counts the processor clock, 25 MHz on this board.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Counts of SysTick in a millisecond.
const COUNTS_PER_MS: u32 = 25_000;

/// Counts within which the interrupt of a new millisecond comes for certain.
const SETTLING_COUNTS: u32 = 50;

static MILLIS: AtomicU32 = AtomicU32::new(0);

/// Starts the clock.
pub fn start(syst: &mut SYST) {
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(COUNTS_PER_MS - 1);
    syst.clear_current();
    syst.enable_counter();
    syst.enable_interrupt();
}

#[cortex_m_rt::exception]
fn SysTick() {
    // No read-modify-write: this handler alone writes.
    MILLIS.store(MILLIS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

/// Milliseconds since the start, modulo 2^32.
pub fn millis() -> u32 {
    MILLIS.load(Ordering::Relaxed)
}

/// Counts of the processor clock since the start, modulo 2^32.
pub fn counts() -> u32 {
    loop {
        let before = millis();
        let left = SYST::get_current();
        // A millisecond that ended between the two makes them a pair that never was; so does one that has just ended and
        // whose interrupt is still to come.
        let settled = left < COUNTS_PER_MS - SETTLING_COUNTS;
        if settled && millis() == before {
            return before.wrapping_mul(COUNTS_PER_MS).wrapping_add(COUNTS_PER_MS - 1 - left);
        }
    }
}
