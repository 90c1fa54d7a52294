//! What the image has measured of itself, told to the emulator by semihosting.

use crate::{clock, uart};
use core::fmt::{Arguments, Write};
use cortex_m_semihosting::hio;
use tactus_common::message::DigestReport;
use tactus_shell::meter::Meter;

/// Value of stack that was never used, as `cortex-m-rt` paints it.
const PAINT: u32 = 0xcccc_cccc;
/// Passes through a loop of two instructions, see `cortex_m::asm::delay`.
const CALIBRATION_LOOPS: u32 = 500_000;

/// Says a line. A handle of its own each time: the library's shared one would have to be borrowed, which may panic.
pub fn say(line: Arguments<'_>) {
    if let Ok(mut host) = hio::hstdout() {
        let _ = host.write_fmt(line);
        let _ = host.write_str("\n");
    }
}

/// Runs a known number of instructions and says how many counts of the clock they took.
pub fn calibration() {
    let begun = clock::counts();
    cortex_m::asm::delay(CALIBRATION_LOOPS);
    let counts = clock::counts().wrapping_sub(begun);
    say(format_args!("tactus: calibration instructions={} counts={}", 2 * CALIBRATION_LOOPS, counts));
}

/// Bytes of stack that were used since the start, and that there are.
fn stack() -> (usize, usize) {
    unsafe extern "C" {
        static mut _stack_end: u32;
        static mut _stack_start: u32;
    }
    let (low, high) = (&raw const _stack_end, &raw const _stack_start);
    let words = (high as usize - low as usize) / size_of::<u32>();
    // SAFETY: the linker's symbols bound the stack region (memory.x), which is readable as words throughout.
    let unused = (0..words).take_while(|&word| unsafe { low.add(word).read_volatile() } == PAINT).count();
    ((words - unused) * size_of::<u32>(), words * size_of::<u32>())
}

/// At the end of a mission.
pub fn mission(report: &DigestReport, meter: &Meter) {
    let digest = u64::from_le_bytes(report.digest);
    let (used, there) = stack();
    say(format_args!(
        "tactus: mission digest={:016x} ticks={} worst_counts={} worst_tick={} mean_counts={} stack={} of={} lost={}",
        digest,
        report.ticks,
        meter.worst,
        meter.worst_at,
        meter.mean(),
        used,
        there,
        uart::RECEIVED.lost()
    ));
}
