//! UART 0: a CMSDK APB UART (ARM DDI 0479, section 4.3). Bytes arrive by interrupt, so that none is lost in a tick.

use core::ptr::{read_volatile, write_volatile};
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use heapless::Vec;
use tactus_common::can::CanFrame;
use tactus_common::slcan;
use tactus_shell::ring::ByteRing;

/// Longest burst between two looks at the queue: a trajectory is 630 lines of 27 bytes, but these the loop takes as
/// they come; a tick of 2 ms is 200 bytes at 1 Mbit/s.
pub static RECEIVED: ByteRing<1024> = ByteRing::new();

/// Registers of UART 0 (AN386, memory map).
const DATA: *mut u32 = 0x4000_4000 as *mut u32;
const STATE: *mut u32 = 0x4000_4004 as *mut u32;
const CONTROL: *mut u32 = 0x4000_4008 as *mut u32;
const INTERRUPT: *mut u32 = 0x4000_400c as *mut u32;
const DIVIDER: *mut u32 = 0x4000_4010 as *mut u32;
/// Bits of `STATE`.
const TX_FULL: u32 = 1 << 0;
const RX_FULL: u32 = 1 << 1;
/// Bits of `CONTROL`: transmitter, receiver, receive interrupt.
const TX_ON: u32 = 1 << 0;
const RX_ON: u32 = 1 << 1;
const RX_INTERRUPT_ON: u32 = 1 << 3;
/// Bit of `INTERRUPT`.
const RX_INTERRUPT: u32 = 1 << 1;
/// 25 MHz / 25 = 1 Mbit/s.
const DIVISION: u32 = 25;

/// Interrupt line of the receiver.
#[derive(Clone, Copy)]
struct RxLine;

const RX_LINE: u16 = 0;

// SAFETY: 0 is the number of UART 0's receive interrupt (AN386, interrupt assignments), one of the board's 32.
unsafe impl InterruptNumber for RxLine {
    fn number(self) -> u16 {
        RX_LINE
    }
}

/// Reads a register of the UART.
fn get(register: *mut u32) -> u32 {
    // SAFETY: called with the constants above alone: addresses of 32-bit registers that exist on this board.
    unsafe { read_volatile(register) }
}

/// Writes a register of the UART.
fn set(register: *mut u32, value: u32) {
    // SAFETY: as in `get`; no register of this UART makes the processor touch memory.
    unsafe { write_volatile(register, value) }
}

/// Switches the UART on.
pub fn start(_: &mut NVIC) {
    set(DIVIDER, DIVISION);
    set(CONTROL, TX_ON | RX_ON | RX_INTERRUPT_ON);
    // SAFETY: the handler below is ready, and no critical section relies on this interrupt being masked.
    unsafe { NVIC::unmask(RxLine) };
}

#[cortex_m_rt::exception]
// SAFETY: cortex-m-rt wants handlers of all interrupts marked unsafe; this one touches the queue (of which it is the
// one writer) and the UART's registers only.
unsafe fn DefaultHandler(line: i16) {
    assert!(line == RX_LINE as i16, "an interrupt that nobody asked for");
    // First the interrupt, then the bytes: one that came between would never be asked for again.
    set(INTERRUPT, RX_INTERRUPT);
    while get(STATE) & RX_FULL != 0 {
        RECEIVED.push(get(DATA) as u8);
    }
}

/// Looks at the queue before it is worth sleeping: bytes of a burst follow one another, and an emulator takes longer to
/// wake than to spin.
const LOOKS: u32 = 10_000;

/// Waits until a byte has arrived or a millisecond has passed, asleep if it takes long.
pub fn wait_until_something_happens() {
    for _ in 0..LOOKS {
        if !RECEIVED.is_empty() {
            return;
        }
    }
    // With interrupts held back a byte that comes after the look wakes the processor all the same.
    cortex_m::interrupt::free(|_| {
        if RECEIVED.is_empty() {
            cortex_m::asm::wfi();
        }
    });
}

/// Sends bytes; waits for the line.
pub fn write(bytes: &[u8]) {
    for byte in bytes {
        while get(STATE) & TX_FULL != 0 {}
        set(DATA, u32::from(*byte));
    }
}

/// Frames of a tick, as lines, until there is time to send them.
pub struct Outbox {
    lines: Vec<u8, 2048>,
}

impl Outbox {
    /// Nothing to send.
    pub const fn new() -> Self {
        Self { lines: Vec::new() }
    }

    /// Adds a frame. Where it does not fit, what waits is sent first.
    pub fn put(&mut self, frame: &CanFrame) {
        let Ok(line) = slcan::encode(frame) else { return };
        if self.lines.extend_from_slice(&line).is_err() {
            self.flush();
            let _ = self.lines.extend_from_slice(&line);
        }
    }

    /// Sends what waits.
    pub fn flush(&mut self) {
        write(&self.lines);
        self.lines.clear();
    }
}
