//! The controller on a Cortex-M4F: frames as SLCAN over UART 0, time from SysTick. The loop and nothing else.
#![no_std]
#![no_main]

mod clock;
mod report;
mod stop;
mod uart;

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::slcan::{self, Line, Parser};
use tactus_shell::Shell;
use tactus_shell::meter::Meter;

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut core = cortex_m::Peripherals::take().expect("taken once, here");
    clock::start(&mut core.SYST);
    uart::start(&mut core.NVIC);
    report::calibration();
    let shell = shell();
    let outbox = cortex_m::singleton!(: uart::Outbox = uart::Outbox::new()).expect("made once, here");
    let mut parser = Parser::new();
    let mut meter = Meter::new();
    loop {
        let Some(byte) = uart::RECEIVED.pop() else {
            shell.idle(clock::millis(), &mut |frame: CanFrame| outbox.put(&frame));
            outbox.flush();
            uart::wait_until_something_happens();
            continue;
        };
        match parser.feed(byte) {
            Some(Line::Frame(frame)) => {
                let (begun, over) = (clock::counts(), shell.node().end().is_some());
                if shell.receive(clock::millis(), &frame, &mut |frame: CanFrame| outbox.put(&frame)) {
                    meter.add(clock::counts().wrapping_sub(begun));
                }
                outbox.flush();
                if let (false, Some((_, end))) = (over, shell.node().end()) {
                    report::mission(&end, &meter);
                }
            }
            Some(Line::Command(_)) => uart::write(&slcan::DONE),
            Some(Line::Done | Line::Refused | Line::Other | Line::Damaged) | None => {}
        }
    }
}

/// Makes the shell. A function of its own, so that the stack which it takes to make one is free again before the first
/// tick.
#[inline(never)]
fn shell() -> &'static mut Shell {
    cortex_m::singleton!(: Shell = Shell::new(Mtu::Classic)).expect("made once, at the start")
}
