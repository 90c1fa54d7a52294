//! Where a panic ends when there is no standard library around it.
//!
//! No input reaches one (the controller's rule); this is for what the compiler could not prove. Unwinding into C is
//! undefined, so the library asks the program to make the robot safe, and stops this thread for good.

use core::ffi::c_char;
use core::panic::PanicInfo;

unsafe extern "C" {
    /// YOU define this one. The library calls it where it finds itself broken, which no input should bring about: make
    /// the robot safe (torque off, brakes) and do not return. If you do, the library keeps this thread in a loop for
    /// ever. `file` has `file_bytes` bytes and no zero at its end. The handle in use is lost; others are not touched.
    fn tactus_panic(file: *const c_char, file_bytes: usize, line: u32);
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    let (file, line) = info.location().map_or(("", 0), |at| (at.file(), at.line()));
    // SAFETY: the program defines this function with these arguments (or does not link); the bytes are static.
    unsafe { tactus_panic(file.as_ptr().cast(), file.len(), line) };
    // A handler that comes back changes nothing: the state that failed must not be used again.
    loop {
        core::hint::spin_loop();
    }
}
