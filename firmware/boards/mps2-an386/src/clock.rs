//! Time: SysTick counts the processor clock, 25 MHz on this board.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use tactus_shell::millis::Millis;

/// Counts of SysTick in a millisecond.
const COUNTS_PER_MS: u32 = 25_000;

/// COUNTER of the board's FPGA: up by one each 40 ns, as long as its prescaler has its reset value 0.
const COUNTER: *const u32 = 0x4002_8018 as *const u32;

static MILLIS: Millis = Millis::new();

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
    MILLIS.count();
}

/// Milliseconds since the start, modulo 2^32.
pub fn millis() -> u32 {
    MILLIS.now()
}

/// Counts of the board's free-running counter, which counts the same clock, modulo 2^32. (SysTick with its interrupt would
/// not do: where the interrupt of a new millisecond comes late, the pair of both is a time that never was.)
pub fn counts() -> u32 {
    // SAFETY: a register of the board that reading does not change.
    unsafe { COUNTER.read_volatile() }
}
