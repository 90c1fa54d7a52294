//! Whole-system tests of Tactus, one file in `tests/` for each promise, and what they have in common.
//!
//! * [`rig`]: the controller's node with a wire in the test's hands: any message, any frame, any silence.
//! * [`recording`]: a mission in the simulated world with all that crossed the wire, to be played to a rig.
//! * [`emulator`]: the firmware image of the emulated board, running.
//! * [`eavesdropper`]: who only listens, and computes the digest from what was on the wire.
//! * [`browser`]: a headless Chromium, driven through its DevTools protocol.
//! * [`can_bench`]: world and controller as processes on `vcan0`.
//! * [`candump`]: the log of an independent witness on a CAN interface.
//! * [`guide`]: the commands of docs/guide.md.
//! * [`process`]: programs that run beside a test.
//! * [`problems`]: pose updates from a seed, without physics, for comparisons and counts.
//! * [`serial_world`]: the world's end of a serial line, in the test's hands.
//! * [`program`]: the `tactus` command, built and run as people do.
//!
//! A recorded mission costs seconds once; a rig plays it in a fraction of one and can be cloned at any tick. So a fault
//! can be injected into every phase.

pub mod browser;
pub mod can_bench;
pub mod candump;
pub mod eavesdropper;
pub mod emulator;
pub mod guide;
pub mod problems;
pub mod process;
pub mod program;
pub mod recording;
pub mod rig;
pub mod serial_world;
