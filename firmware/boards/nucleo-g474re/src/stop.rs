//! What happens when something that cannot happen has happened: off the bus, light on, and never a command again. The
//! drives let go by themselves after 20 ticks without one.

use core::panic::PanicInfo;
use embassy_stm32::pac;

/// Pin of the light on port A.
const LIGHT: usize = 5;

#[panic_handler]
fn stop(_: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    // The frame on the wire is cut off, which every receiver notices; the transmit pin stays recessive.
    pac::FDCAN1.cccr().modify(|w| w.set_init(true));
    pac::GPIOA.bsrr().write(|w| w.set_bs(LIGHT, true));
    loop {
        core::hint::spin_loop();
    }
}

#[cortex_m_rt::exception]
// SAFETY: cortex-m-rt wants this marked unsafe; it does nothing but stop.
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    panic!("the processor cannot go on: stack overflow, most likely")
}
