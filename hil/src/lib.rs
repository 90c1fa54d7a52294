//! Buses that carry Tactus frames, and what it costs to carry them.
//!
//! * [`bus`]: the seam: what a node needs of a bus, whichever it is.
//! * [`bus_name`]: buses outside this process by name. [`shell`]: the controller as a process on one.
//! * [`choice`], [`usage`], [`say`]: what the programs have in common: names of formats and paces, usage errors in one line,
//!   output that may be closed.
//! * [`virtual_bus`]: a CAN bus within the process: arbitration, exact bit times, bounded queues, faults by seed.
//! * [`socketcan_bus`]: Linux's own CAN interfaces.
//! * [`slcan_bus`]: frames as text over a serial port, a pseudo terminal or a Unix socket.
//! * [`bit_time`]: how long a frame keeps the wire busy, exactly and at worst.
//! * [`bus_load`]: the share of the wire that a set of periodic messages takes at worst.
//! * [`bus_meter`]: the load of a bus outside this process, from the frames seen.
//! * [`load_window`]: the busiest 100 ms of a run.
//! * [`puck_responder`]: the other end of Barrett's puck protocol, for tests.
#![forbid(unsafe_code)]
// What is printed goes through `say`, whose reader may be gone.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod bit_time;
pub mod bus;
pub mod bus_load;
pub mod bus_meter;
pub mod bus_name;
pub mod choice;
pub mod load_window;
pub mod puck_responder;
pub mod say;
pub mod shell;
pub mod slcan_bus;
pub mod socketcan_bus;
pub mod usage;
pub mod virtual_bus;
