//! Time. SysTick makes milliseconds; timer 0 (CMSDK APB timer, ARM DDI 0479, section 4.2) counts the processor clock,
//! 25 MHz on this board.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// Counts of SysTick in a millisecond.
const COUNTS_PER_MS: u32 = 25_000;

/// Registers of timer 0 (AN386, memory map).
const TIMER_CONTROL: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER_VALUE: *mut u32 = 0x4000_0004 as *mut u32;
const TIMER_RELOAD: *mut u32 = 0x4000_0008 as *mut u32;
/// Bit of `TIMER_CONTROL`.
const TIMER_ON: u32 = 1 << 0;

static MILLIS: AtomicU32 = AtomicU32::new(0);

/// Starts both.
pub fn start(syst: &mut SYST) {
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(COUNTS_PER_MS - 1);
    syst.clear_current();
    syst.enable_counter();
    syst.enable_interrupt();
    // SAFETY: addresses of 32-bit registers that exist on this board; this timer makes the processor touch no memory.
    unsafe {
        TIMER_RELOAD.write_volatile(u32::MAX);
        TIMER_VALUE.write_volatile(u32::MAX);
        TIMER_CONTROL.write_volatile(TIMER_ON);
    }
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

/// Counts of the processor clock since the start, modulo 2^32. By a timer of its own: SysTick's value and the milliseconds
/// that its interrupt counts are a pair that may be a millisecond apart.
pub fn counts() -> u32 {
    // SAFETY: an address of a 32-bit register that exists on this board; reading it has no effect.
    u32::MAX - unsafe { TIMER_VALUE.read_volatile() }
}
