//! The controller on ST's Nucleo-G474RE: frames over the chip's own CAN FD peripheral. The loop and nothing else.
//!
//! Why this board: the STM32G474 is the smallest common Cortex-M4F with CAN FD (170 MHz, 512 KiB of flash, 128 KiB of
//! RAM; the STM32F4 and its bxCAN know CAN 2.0 only, which carries real time at 250 Hz at most), the board has the
//! 24 MHz crystal that 5 Mbit/s need, and costs little. Why `embassy-stm32`: it is the maintained driver library of this
//! family, and its buffered FDCAN needs no executor: interrupts fill and drain two queues, this loop takes and puts.
//!
//! Wiring: a CAN FD transceiver (none is on the board) at PA11 (CN10-14, receive) and PA12 (CN10-12, transmit). The
//! green LED LD2 (PA5) tells the state: off = no mission, on = a mission runs, on with the bus dead = stopped.
//!
//! It is built by `cargo xtask cross`; nobody has yet run it on a board.
#![no_std]
#![no_main]

mod bus;
mod clock;
mod stop;

use embassy_stm32::gpio::{Level, Output, Speed};
use tactus_common::can::{CanFrame, Mtu};
use tactus_shell::{REALTIME_SILENCE_MS, SILENCE_MS, Shell};

/// The format of the frames that it sends; it receives both.
const MTU: Mtu = if cfg!(feature = "classic") { Mtu::Classic } else { Mtu::Fd };
/// Silence after which the world is given up: a robot's readings come every period, a simulation may pause.
const SILENT_AFTER_MS: u32 = if cfg!(feature = "lockstep") { SILENCE_MS } else { REALTIME_SILENCE_MS };

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut core = cortex_m::Peripherals::take().expect("taken once, here");
    let chip = embassy_stm32::init(clock::config());
    clock::start(&mut core.SYST);
    let mut light = Output::new(chip.PA5, Level::Low, Speed::Low);
    let mut bus = bus::start(chip.FDCAN1, chip.PA11, chip.PA12);
    let shell = cortex_m::singleton!(: Shell = Shell::with_silence(MTU, SILENT_AFTER_MS)).expect("made once, here");
    loop {
        let now_ms = clock::millis();
        match bus.receive() {
            Some(frame) => shell.receive(now_ms, &frame, &mut |frame: CanFrame| bus.send(&frame)),
            None => shell.idle(now_ms, &mut |frame: CanFrame| bus.send(&frame)),
        };
        light.set_level(if shell.node().is_free() { Level::Low } else { Level::High });
    }
}
