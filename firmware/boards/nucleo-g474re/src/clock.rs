//! The chip's clocks, and milliseconds from SysTick.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use embassy_stm32::Config;
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use embassy_stm32::time::Hertz;

/// The processor's clock, and that of the CAN peripheral.
pub const CLOCK_HZ: u32 = 170_000_000;

static MILLIS: AtomicU32 = AtomicU32::new(0);

/// 170 MHz from the board's crystal: 24 MHz / 6 * 85 / 2. The chip's own oscillator (1 %) is too coarse for CAN FD.
pub fn config() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(24_000_000), mode: HseMode::Oscillator });
    config.rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    // Above 150 MHz the core needs its higher voltage.
    config.rcc.boost = true;
    config.rcc.mux.fdcansel = mux::Fdcansel::PCLK1;
    config
}

/// Starts the milliseconds.
pub fn start(syst: &mut SYST) {
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(CLOCK_HZ / 1_000 - 1);
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
