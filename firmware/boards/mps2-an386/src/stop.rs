//! What happens when something that cannot happen has happened: say where, then never command again. The drives let go
//! by themselves after 20 ticks without a command.

use core::fmt::Write;
use core::panic::PanicInfo;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE};

/// UART 0 as a place for text. A line of text is no SLCAN line: who listens for frames skips it.
struct Text;

impl Write for Text {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        crate::uart::write(text.as_bytes());
        Ok(())
    }
}

#[panic_handler]
fn stop(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    // The end of whatever line was being sent. The message itself would need the formatting of every type.
    let (file, line) = info.location().map_or(("?", 0), |place| (place.file(), place.line()));
    let _ = write!(Text, "\r#tactus stopped at {file}:{line}\r");
    crate::report::say(format_args!("tactus stopped at {file}:{line}"));
    loop {
        debug::exit(EXIT_FAILURE);
    }
}

#[cortex_m_rt::exception]
// SAFETY: cortex-m-rt wants this marked unsafe; it does nothing but stop.
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    panic!("the processor cannot go on: stack overflow, most likely")
}
